"""Servo readings and what happened on the wire, as lines of text. Pure."""

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.frames import ALERT
from drivers.dynamixel.mx106 import hardware_error_names, joint_state
from drivers.dynamixel.stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US, BusStats
from model.values.readings import ServoReadings
from robot.console.table import number_text

BAR = 40


def table_lines(bus: ServoBus, readings: ServoReadings, seconds: float) -> list[str]:
    """Return one screen: a line a servo and one of counters. What is missing is a dash."""
    joints = joint_state(readings, bus.settings)
    stats = bus.stats
    median = stats.median_round_trip_us
    trip = "no complete read" if median is None else f"half within {median * 1e-3:.2f} ms"
    lines = [
        f"{seconds:8.1f} s  round trips: {trip}, longest "
        f"{stats.longest_round_trip_us * 1e-3:.2f} ms  {counter_line(stats)}",
        "leg  id   ticks      rad   rad/s      A      V  degC   age ms  errors",
    ]
    for i, name in enumerate(bus.settings.names):
        ticks = f"{readings.position_ticks[i]:7d}" if readings.valid[i] else f"{'-':>7}"
        cells = [
            number_text(joints.angle_rad[i], 3, 9),
            number_text(joints.rate_rad_s[i], 2, 8),
            number_text(joints.current_a[i], 2, 7),
            number_text(joints.voltage_v[i], 1, 7),
            number_text(joints.temperature_c[i], 0, 6),
            number_text(
                readings.age_ns[i] * 1e-6 if readings.age_ns[i] >= 0 else float("nan"), 1, 9
            ),
        ]
        lines.append(
            f"{name:<4} {int(bus.settings.ids[i]):>3} {ticks}{''.join(cells)}  "
            f"{error_words(readings, i)}"
        )
    return lines


def error_words(readings: ServoReadings, index: int) -> str:
    """Return what a servo reports, in words."""
    if not readings.valid[index]:
        return "silent"
    value = int(readings.hardware_error[index])
    if value > 0:
        return ", ".join(hardware_error_names(value))
    if readings.error_byte[index] & ALERT:
        return "alert, cause not read yet"
    return "not read yet" if value < 0 else "none"


def counter_line(stats: BusStats) -> str:
    """Return the counters of the wire."""
    return (
        f"reads {stats.reads}  timeouts {stats.timeouts}  CRC {stats.crc_errors}  "
        f"late {stats.late_replies}  foreign {stats.foreign_replies}  "
        f"noise bytes {stats.noise_bytes}"
    )


def stats_lines(stats: BusStats) -> list[str]:
    """Return both histograms and the counters."""
    return [
        "round trip of complete reads",
        *histogram_lines(stats.round_trips, ROUND_TRIP_EDGES_US),
        f"  longest {stats.longest_round_trip_us * 1e-3:.2f} ms",
        "jitter: change of the time from one read to the next",
        *histogram_lines(stats.jitters, JITTER_EDGES_US),
        f"  largest {stats.largest_jitter_us * 1e-3:.2f} ms",
        counter_line(stats),
    ]


def histogram_lines(counts: tuple[int, ...], edges_us: tuple[int, ...]) -> list[str]:
    """Return a histogram as lines, empty classes at both ends left out."""
    labels = [f"< {edge * 1e-3:g} ms" for edge in edges_us] + [f">= {edges_us[-1] * 1e-3:g} ms"]
    filled = [i for i, count in enumerate(counts) if count]
    if not filled:
        return ["  none"]
    most = max(counts)
    return [
        f"  {labels[i]:>10} {counts[i]:7d}  {'#' * -(-BAR * counts[i] // most)}"
        for i in range(filled[0], filled[-1] + 1)
    ]
