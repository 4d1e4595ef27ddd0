"""The servos' part of the pre-flight list."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import READ_LENGTH
from drivers.dynamixel.condition import ServoCondition, read_condition
from drivers.dynamixel.frames import STATUS_BYTES
from drivers.dynamixel.model_words import mismatch_words
from drivers.dynamixel.port import BITS_PER_BYTE
from drivers.dynamixel.registers import OperatingMode
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.setup import (
    LONGEST_QUIET_RETURN_DELAY,
    WARN_LATENCY_MS,
)
from drivers.dynamixel.watchdog import prove_watchdog
from model.errors import BusError, ConnectionLost
from robot.bringup.preflight.finding import (
    CheckVerdict,
    Finding,
    about,
    failed,
    passed,
    skipped,
    warned,
)
from robot.bringup.preflight.servo_figures import ServoFigures
from robot.config.robot_file import RobotConfig
from robot.config.servo import SafetyLimits

READS = 100
WARM_MARGIN_C = 15.0
# Servos on one supply that differ by more than this have a bad cable or plug between them.
LARGEST_VOLTAGE_SPREAD_V = 0.5
KNOCKS = 5
# Bytes of a sync read's request besides the ids, and of an answer besides its data.
SYNC_READ_BYTES = 14

# A round trip longer than this many times its bytes is not the wire's.
WIRE_SHARE = 3.0


class _Those(NamedTuple):
    """Servos that something holds for: in words, and their legs."""

    words: str
    legs: tuple[str, ...]


def servo_findings(
    bus: ServoBus, config: RobotConfig, *, armed: bool, figures: ServoFigures | None = None
) -> Iterator[Finding]:
    """Look at the servos, one finding after the other. The port is left open.

    Args:
        bus: The bus, not yet open.
        config: Robot file.
        armed: Whether torque may be switched on, at the measured positions, to prove the watchdog.
        figures: Takes what is measured; None for nobody.

    Raises:
        ConnectionLost: The port is gone.
    """
    figures = figures or ServoFigures()
    try:
        bus.open()
    except ConnectionLost:
        raise
    except BusError as error:
        yield failed("port", str(error), "plug it in or choose another port with --hardware PORT")
        return
    yield passed("port", f"opens at {bus.settings.baud_rate} baud")
    yield latency_finding(bus.latency_timer_ms)
    missing, conditions, broken = _ask(bus)
    figures.conditions += conditions
    yield _answer_finding(bus, missing, broken)
    if not conditions:
        return
    findings = condition_findings(conditions, config.limits, bus.settings.model_of_leg)
    yield from findings
    well = not missing and not broken and all(f.verdict is not CheckVerdict.FAIL for f in findings)
    if not well:
        yield skipped("bus traffic", "first fix the failures above")
        yield skipped("watchdog", "first fix the failures above")
        return
    try:
        bus.connect()
        yield _traffic_finding(bus, round(1e9 / config.loop.rate_hz), figures)
        yield _watchdog_finding(bus, armed=armed)
    except ConnectionLost:
        raise
    except BusError as error:
        yield failed("servos", str(error), "correct it and check again")


def latency_finding(latency_ms: float | None) -> Finding:
    """Judge the adapter's latency timer."""
    if latency_ms is None:
        return passed("latency timer", "this port has none that the system shows")
    found = f"{latency_ms:.0f} ms"
    if latency_ms > WARN_LATENCY_MS:
        return warned(
            "latency timer", found, "write 1 to latency_timer in /sys/bus/usb-serial/devices/..."
        )
    return passed("latency timer", found)


def _ask(bus: ServoBus) -> tuple[dict[str, str], list[ServoCondition], dict[str, str]]:
    """Return who is missing, the condition of the others, and what some did not tell, by leg."""
    missing: dict[str, str] = {}
    conditions: list[ServoCondition] = []
    broken: dict[str, str] = {}
    for servo in bus.servos():
        if not any(servo.answers() for _ in range(KNOCKS)):
            missing[servo.leg] = f"{servo.leg} (id {servo.servo_id})"
            continue
        try:
            conditions.append(read_condition(servo))
        except ConnectionLost:
            raise
        except BusError as error:
            broken[servo.leg] = str(error)
    return missing, conditions, broken


def _answer_finding(bus: ServoBus, missing: dict[str, str], broken: dict[str, str]) -> Finding:
    count = len(bus.settings.names)
    if missing:
        found = f"{len(missing)} of {count} silent: {', '.join(missing.values())}"
        advice = "check power and cable, then id and baud rate with: bigant devices"
        return about(missing, failed("servos answer", found, advice))
    if broken:
        found = "; ".join(broken.values())
        return about(broken, failed("servos answer", found, "switch the servos off and on"))
    return passed("servos answer", f"all {count}")


def condition_findings(
    conditions: Sequence[ServoCondition], limits: SafetyLimits, models: Mapping[str, ServoModel]
) -> list[Finding]:
    """Judge what the servos say of themselves. Pure.

    Args:
        conditions: One servo or more.
        limits: Safety limits of the robot file.
        models: Model of each leg's servo, by leg.
    """
    mode = OperatingMode.EXTENDED_POSITION
    on = _those(conditions, lambda c: c.torque, lambda _: "holds")
    return [
        _models(conditions, models),
        _firmware(conditions, models),
        _judged(
            "operating mode",
            warned,
            _those(
                conditions,
                lambda c: c.operating_mode != mode,
                lambda c: f"in mode {c.operating_mode}",
            ),
            "an armed drive sets it to 4, extended position; bigant servo setup does so now",
            "4, extended position",
        ),
        _judged(
            "return delay",
            warned,
            _those(
                conditions,
                lambda c: c.return_delay > LONGEST_QUIET_RETURN_DELAY,
                lambda c: f"waits {c.return_delay_us:.0f} us",
            ),
            "set it to 0 with: bigant servo setup",
            f"{max(c.return_delay_us for c in conditions):.0f} us",
        ),
        _judged(
            "homing offset",
            failed,
            _those(conditions, lambda c: c.homing_offset != 0, lambda c: f"has {c.homing_offset}"),
            "set it to 0 with bigant servo setup and put it into servo_zero (bigant servo zero)",
            "0",
        ),
        _voltages(conditions, limits.min_voltage_v),
        _temperatures(conditions, limits.max_temperature_c),
        _errors(conditions),
        _judged(
            "torque",
            failed,
            on._replace(words=f"on, and nobody drives: {on.words}" if on.words else ""),
            "support the robot, then: bigant servo reboot --id all --yes",
            "off",
        ),
    ]


def _judged(
    name: str, verdict: Callable[[str, str, str], Finding], bad: _Those, advice: str, good: str
) -> Finding:
    return about(bad.legs, verdict(name, bad.words, advice)) if bad.words else passed(name, good)


def _those(
    conditions: Sequence[ServoCondition],
    bad: Callable[[ServoCondition], bool],
    words: Callable[[ServoCondition], str],
) -> _Those:
    those = [c for c in conditions if bad(c)]
    return _Those(", ".join(f"{c.who} {words(c)}" for c in those), tuple(c.leg for c in those))


def _models(conditions: Sequence[ServoCondition], models: Mapping[str, ServoModel]) -> Finding:
    """Judge whether each servo is what the robot file says; say whose current is not measured."""
    wrong = [(c, mismatch_words(models[c.leg], c.model)) for c in conditions]
    bad = "; ".join(f"{c.who} {words}" for c, words in wrong if words)
    if bad:
        advice = "check the ids, and model in [servo] of the robot file"
        return about((c.leg for c, words in wrong if words), failed("model", bad, advice))
    used = {models[c.leg] for c in conditions}
    unmeasured = sorted(model.name for model in used if not model.measures_current)
    words = ", ".join(sorted(model.name for model in used))
    if unmeasured:
        words += f"; no limit on current is judged: an {', '.join(unmeasured)} measures none"
    return passed("model", words)


def _firmware(conditions: Sequence[ServoCondition], models: Mapping[str, ServoModel]) -> Finding:
    versions = sorted({c.firmware for c in conditions})
    found = "version " + ", ".join(str(v) for v in versions)
    old = _those(
        conditions,
        lambda c: c.firmware < models[c.leg].watchdog_firmware,
        lambda c: f"has {c.firmware}",
    )
    if old.words:
        advice = "update the firmware with Dynamixel Wizard"
        return about(old.legs, failed("firmware", f"{old.words}: no watchdog", advice))
    if len({(c.model, c.firmware) for c in conditions}) > len({c.model for c in conditions}):
        return warned("firmware", found, "give all servos the same firmware")
    return passed("firmware", found)


def _voltages(conditions: Sequence[ServoCondition], lowest_v: float) -> Finding:
    volts = [c.voltage_v for c in conditions]
    low = _those(conditions, lambda c: c.voltage_v < lowest_v, lambda c: f"has {c.voltage_v:.1f} V")
    if low.words:
        advice = f"charge or change the battery: {lowest_v:g} V at least"
        return about(low.legs, failed("voltage", low.words, advice))
    found = f"{min(volts):.1f} to {max(volts):.1f} V"
    if max(volts) - min(volts) > LARGEST_VOLTAGE_SPREAD_V:
        lowest = min(conditions, key=lambda c: c.voltage_v)
        advice = f"check cable and plugs of {lowest.who}, the lowest"
        return about((lowest.leg,), warned("voltage", found, advice))
    return passed("voltage", found)


def _temperatures(conditions: Sequence[ServoCondition], highest_c: float) -> Finding:
    hottest = max(conditions, key=lambda c: c.temperature_c)
    found = f"up to {hottest.temperature_c:.0f} degC ({hottest.who})"
    for limit_c, verdict, advice in (
        (highest_c, failed, f"let it cool: the limit is {highest_c:g} degC"),
        (highest_c - WARM_MARGIN_C, warned, f"close to the limit of {highest_c:g} degC: wait"),
    ):
        hot = [c.leg for c in conditions if c.temperature_c >= limit_c]
        if hot:
            return about(hot, verdict("temperature", found, advice))
    return passed("temperature", found)


def _errors(conditions: Sequence[ServoCondition]) -> Finding:
    bad = _those(
        conditions, lambda c: c.hardware_error != 0, lambda c: f"has {', '.join(c.error_names)}"
    )
    advice = "remove the cause, then: bigant servo reboot --id all"
    if any(c.has_shut_down for c in conditions):
        return about(bad.legs, failed("hardware errors", f"{bad.words} (shut down)", advice))
    return _judged("hardware errors", warned, bad, advice, "none")


def _traffic_finding(bus: ServoBus, period_ns: int, figures: ServoFigures) -> Finding:
    figures.period_ms, figures.wire_ms = period_ns * 1e-6, wire_ms(bus.settings)
    before = bus.stats
    deadline_ns = bus.clock.now_ns()
    lost = 0
    for _ in range(READS):
        began_ns = bus.clock.now_ns()
        valid = bus.read().valid
        figures.read_ms.append((bus.clock.now_ns() - began_ns) * 1e-6)
        figures.complete.append(bool(valid.all()))
        lost += int(np.count_nonzero(~valid))
        deadline_ns = max(deadline_ns + period_ns, bus.clock.now_ns())
        bus.clock.sleep_until_ns(deadline_ns)
    stats = bus.stats
    median_us = stats.median_round_trip_us
    damaged = stats.crc_errors - before.crc_errors
    expected = READS * len(bus.settings.names)
    found = (
        f"{lost} of {expected} answers lost, {damaged} damaged, half of the round trips within "
        f"{median_us * 1e-3 if median_us is not None else float('nan'):.2f} ms"
    )
    if lost > expected // 100:
        return failed("bus traffic", found, "check cables and baud rate; see bigant servo watch")
    if median_us is not None and median_us > period_ns * 0.5e-3:
        return warned(
            "bus traffic",
            f"{found}, of a period of {period_ns * 1e-6:g} ms",
            bus_advice(median_us * 1e-3, wire_ms(bus.settings), bus.latency_timer_ms),
        )
    if lost or damaged:
        return warned("bus traffic", found, "look again with bigant servo watch; check cables")
    return passed("bus traffic", found)


def wire_ms(settings: ServoBusSettings) -> float:
    """Return how long the bytes of one sync read of all servos take [ms]."""
    count = len(settings.ids)
    request = SYNC_READ_BYTES + count
    return (
        (request + (STATUS_BYTES + READ_LENGTH) * count)
        * BITS_PER_BYTE
        * 1e3
        / (settings.baud_rate)
    )


def bus_advice(round_trip_ms: float, on_the_wire_ms: float, latency_ms: float | None) -> str:
    """Say what makes round trips long: the adapter, the wire, or this computer. Pure."""
    if latency_ms is not None and latency_ms > 1:
        return f"the latency timer is {latency_ms:.0f} ms: set it to 1"
    if round_trip_ms < WIRE_SHARE * on_the_wire_ms:
        return (
            f"the bytes alone take {on_the_wire_ms:.1f} ms: raise servo_bus.baud_rate, and set the "
            "return delay to 0 (bigant servo setup)"
        )
    return (
        f"the bytes take {on_the_wire_ms:.1f} ms only: this computer or the adapter is late; stop "
        "other programs and look again with --loop"
    )


def _watchdog_finding(bus: ServoBus, *, armed: bool) -> Finding:
    if not armed:
        return skipped(
            "watchdog", "its proof needs torque (holding still): lift the robot and add --armed"
        )
    bus.configure()
    proof = prove_watchdog(bus)
    if not proof.torque_off:
        return failed("watchdog", "TORQUE NOT CONFIRMED OFF", "cut the power")
    if proof.asleep:
        found = f"did not trip in {proof.silent_s:.2f} s of silence: {', '.join(proof.asleep)}"
        return about(proof.asleep, failed("watchdog", found, "do not walk; update their firmware"))
    return passed(
        "watchdog",
        f"all {len(proof.tripped)} tripped in {proof.silent_s:.2f} s of silence; torque off again",
    )
