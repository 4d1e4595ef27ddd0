"""The summary of a run as rows of text, each of which stands alone; "-" where a figure is not known."""

import math

from model.values.faults import StopReason
from record.log.header import IMPORTED
from robot.console.table import number_text
from robot.control.stops import STOPS
from robot.report.summary import PERCENTILES, Summary, reason_of

Row = tuple[str, str]
MOST_LAST_FAULTS = 3
MISSED_LIMIT = 0.02  # of the periods of a run


def summary_rows(summary: Summary) -> list[Row]:
    """Return label and text of each row of the table; what the run did not do has no row.

    Nor has what was not measured in imported data, in which no loop and no model of ours ran.
    """
    return [row for rows in summary_groups(summary).values() for row in rows]


def summary_groups(summary: Summary) -> dict[str, list[Row]]:
    """Return the same rows in groups, by the title of the group."""
    s = summary
    imported = s.hardware == IMPORTED
    going = reason_of(s.stop_reason) is StopReason.NONE
    ended = "not ended in this log" if going else f"ended: {s.stop_reason}"
    run = f"{s.gait} on {s.hardware}, {s.duration_s:.1f} s, {ended}"
    rows = [("run", f"{s.gait}, imported data, {s.duration_s:.1f} s" if imported else run)]
    walk = _walk_rows(s)
    if s.truth and (math.isfinite(s.drift_m) or not imported):
        walk.append(("drift of dead reckoning", _drift_words(s.walk_drift_m, s.drift_m)))
    forces = []
    if not s.forces:
        forces.append(("foot forces", "none measured" if s.sensors else "no force sensors"))
    elif math.isfinite(s.force_rmse_n[0]):
        forces.append(("predicted foot force, RMSE", _force_words(s.force_rmse_n)))
    estimator = [("IMU", _imu_words(s))] if any(s.imu_share) else []
    if math.isfinite(s.estimate_health[0]):
        estimator += _estimator_rows(s)
    groups = {
        "Run": [*rows, *_stop_rows(s)], "Walk": walk, "Foot forces": forces, "Estimator": estimator,
        "Loop, servos, faults": _device_rows(s, imported=imported),
    }  # fmt: skip
    return {title: rows for title, rows in groups.items() if rows}


def _device_rows(s: Summary, *, imported: bool) -> list[Row]:
    timing = (
        f"{s.ticks} ticks, late p50 {s.late_p50_ms:.2f} p99 {s.late_p99_ms:.2f} "
        f"max {s.late_max_ms:.2f} ms, {s.missed} missed"
    )
    rows = [("samples", str(s.ticks)) if imported else ("loop", timing)]
    if math.isfinite(s.hottest_c) or not imported:
        rows.append(("hottest servo", f"{number_text(s.hottest_c, 0)} C"))
    if s.faults or not imported:
        words = ", ".join(f"{kind} in {_ticks(n)}" for kind, n in s.faults) or "none"
        rows.append(("faults", words))
    if s.damage:
        rows.append(("file", s.damage))
    return rows


def run_sentence(s: Summary) -> str:
    """Return what a run did in one sentence."""
    if s.walking_s <= 0:
        did = f"It did not walk in {s.duration_s:.1f} s"
    else:
        cycles = f"{number_text(s.cycles, 2)} cycles of {s.gait}, " if s.cycles > 0 else ""
        source = "" if s.truth else " by its own estimate"
        did = (f"It walked {number_text(s.forward_m, 3)} m forward{source} in {s.walking_s:.1f} s "
               f"({cycles}{_milli(s.mean_speed_m_s)} mm/s)")  # fmt: skip
    reason = reason_of(s.stop_reason)
    if not STOPS[reason].wished:
        return f"{did} and stopped because of a fault: {STOPS[reason].words}."
    kinds = len(s.faults)
    return f"{did}, without a fault." if not kinds else (
        f"{did}, with {kinds} kind{'s' if kinds > 1 else ''} of fault."
    )  # fmt: skip


def run_facts(s: Summary) -> list[Row]:
    """Return the few numbers of a run that count most, each with what it is a number of."""
    if s.walking_s <= 0:
        return []
    source = "true" if s.truth else "estimated"
    facts = [
        (f"{number_text(s.forward_m, 3)} m", f"forward while walking ({source})"),
        (f"{_milli(s.mean_speed_m_s)} mm/s", "mean speed forward"),
        (f"{number_text(math.degrees(s.yaw_rad), 1)} deg", "turned while walking"),
    ]
    low, *_, high = s.slip_percentiles_m_s
    if math.isfinite(low):
        facts.append((f"{_milli(low)} to {_milli(high)} mm/s",
                      f"forward slip of loaded feet, 5 to 95 % ({source})"))  # fmt: skip
    if math.isfinite(s.estimate_walk_drift_m):
        facts.append(
            (f"{_milli(s.estimate_walk_drift_m)} mm", "drift of the estimator while walking")
        )
    return facts


def _imu_words(s: Summary) -> str:
    rate, roll, pitch = s.imu_share
    parts = []
    if rate:
        parts.append(f"yaw rate in {rate:.0%} of the ticks")
    if roll or pitch:
        parts.append(f"roll and pitch in {max(roll, pitch):.0%}")
    if math.isfinite(s.gyro_bias[0]):
        bias, sd = (_milli(value) for value in s.gyro_bias)
        parts.append(f"gyro bias {bias} +- {sd} mrad/s at the end")
    return ", ".join(parts)


def _ticks(count: int) -> str:
    return "1 tick" if count == 1 else f"{count} ticks"


def _stop_rows(s: Summary) -> list[Row]:
    """Why a run stopped that nobody ended, when, and what went wrong last."""
    reason = reason_of(s.stop_reason)
    if STOPS[reason].wished:
        return []
    cause = f" ({s.stop_cause})" if s.stop_cause else ""
    when = f", from {number_text(s.stop_s, 2)} s on"
    last = [f"{words} at {t_s:.2f} s" for t_s, words in s.last_faults[:MOST_LAST_FAULTS]]
    rows = [("stopped because", f"{STOPS[reason].words}{cause}{when}")]
    return rows + ([("last faults", "; ".join(last))] if last else [])


def _walk_rows(s: Summary) -> list[Row]:
    if s.walking_s <= 0:
        return [("walked", "did not walk")]
    source = "true" if s.truth else "estimated"
    slip = ", ".join(
        f"{p} %: {_milli(v)}" for p, v in zip(PERCENTILES, s.slip_percentiles_m_s, strict=True)
    )
    rows = [
        ("walked", f"{number_text(s.cycles, 2)} cycles in {s.walking_s:.1f} s"),
        ("distance", f"{number_text(s.distance_m, 3)} m ({source}, walking), "
         f"forward {number_text(s.forward_m, 3)} m"),
        ("mean speed", f"{_milli(s.mean_speed_m_s)} mm/s forward (walking)"),
        ("turned", f"{number_text(math.degrees(s.yaw_rad), 1)} deg (walking)"),
    ]  # fmt: skip
    if math.isfinite(s.slip_percentiles_m_s[0]):
        rows.append(("forward slip of loaded feet", f"{slip} mm/s ({source}, walking)"))
    if s.truth and (math.isfinite(s.velocity_rmse[0]) or s.hardware != IMPORTED):
        rows.append(("predicted velocity, RMSE", f"{_velocity_words(s.velocity_rmse)} (walking)"))
    if s.truth:
        rows.append(("true velocity, RMS", f"{_velocity_words(s.velocity_rms)} (walking)"))
    return rows


def _estimator_rows(s: Summary) -> list[Row]:
    ok, degraded, lost = (100 * share for share in s.estimate_health)
    x, y, yaw = (_milli(value) for value in s.estimate_sd)
    rows = [
        ("estimator", f"ok {ok:.1f} %, degraded {degraded:.1f} %, lost {lost:.1f} % of the run"),
        ("estimator's sd at the end", f"x {x}, y {y} mm, yaw {yaw} mrad (whole run)"),
    ]  # fmt: skip
    if s.truth:
        if s.walking_s > 0:
            words = f"{_velocity_words(s.estimate_rmse)} (walking)"
            rows.append(("estimator's velocity, RMSE", words))
        rows.append(
            ("drift of the estimator", _drift_words(s.estimate_walk_drift_m, s.estimate_drift_m))
        )
    if math.isfinite(s.estimate_force_rmse_n[0]):
        rows.append(("estimator's foot force, RMSE", _force_words(s.estimate_force_rmse_n)))
    return rows


def _milli(value: float) -> str:
    return number_text(value * 1e3, 1)


def _drift_words(walk_m: float, run_m: float) -> str:
    """How far the end is off: over the walk if there was one, and over all of the run."""
    whole = f"{_milli(run_m)} mm (whole run)"
    return f"{_milli(walk_m)} mm (walking), {whole}" if math.isfinite(walk_m) else whole


def _force_words(values: tuple[float, ...]) -> str:
    words = (f"{axis} {number_text(v, 2)}" for axis, v in zip("xyz", values, strict=True))
    return ", ".join(words) + " N (walking)"


def _velocity_words(values: tuple[float, ...]) -> str:
    x, y, yaw = (_milli(value) for value in values)
    return f"vx {x}, vy {y} mm/s, yaw rate {yaw} mrad/s"


def busy_words(missed: int, ticks: int, *, virtual: bool) -> str:
    """Return one line for a run in real time that missed many periods; empty where it kept up.

    A run on virtual devices can leave real time.
    """
    periods = ticks + missed
    if missed <= MISSED_LIMIT * periods:
        return ""
    advice = "see what slows it with: bigant check --computer"
    if virtual:
        advice = f"use --virtual-time, or {advice}"
    return (
        f"warning: this computer was too busy for real time: {missed} of {periods} periods "
        f"never ran; {advice}"
    )
