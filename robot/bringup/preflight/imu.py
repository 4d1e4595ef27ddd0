"""Is the IMU of a robot file there, at rest, and sound? Listens for a while; nothing is sent."""

from collections.abc import Iterator
from math import degrees

import numpy as np

from drivers.clock import Clock
from drivers.lines.imu import ImuListener
from model.values.readings import ImuRecord
from robot.bringup.preflight.finding import Finding, failed, passed, warned
from robot.config.imu import ImuConfig
from robot.control.imu import MountedImu

NAME = "imu"
SLOWEST_HZ = 10.0
PERIOD_NS = 10_000_000
LARGEST_BIAS_RAD_S = 0.05  # five times what the estimator expects of a bias
STEEPEST_RAD = 0.35  # beyond it the mounting is wrong rather than the floor


def imu_findings(
    listener: ImuListener, config: ImuConfig, clock: Clock, seconds: float
) -> Iterator[Finding]:
    """Listen to an IMU on a robot that stands still.

    Args:
        listener: The IMU.
        config: How it is mounted.
        clock: The clock of its readings.
        seconds: For so long.
    """
    began_ns = now_ns = clock.now_ns()
    readings: list[ImuRecord] = []
    faults: dict[str, str] = {}
    while now_ns - began_ns < seconds * 1e9:
        clock.sleep_until_ns(now_ns + PERIOD_NS)
        now_ns = clock.now_ns()
        new, bad = listener.read()
        readings += new
        faults |= {fault.kind.name: fault.detail for fault in bad}
    words = "; ".join(f"{kind}: {detail}" for kind, detail in faults.items())
    if not readings:
        why = words or f"no reading in {seconds:g} s"
        yield failed(NAME, why, "check its port, its power and what it prints (docs/odometry.md)")
        return
    yield _judged(readings, config, seconds, words)


def _judged(readings: list[ImuRecord], config: ImuConfig, seconds: float, faults: str) -> Finding:
    mounted = MountedImu(config)
    rows = np.array([mounted.of_body((one,), one.t_ns) for one in readings])
    rate_hz = len(readings) / seconds
    parts, advice = [f"{rate_hz:.0f} readings a second"], []
    known = [rows[np.isfinite(rows[:, k]), k] for k in range(3)]
    if len(known[0]):
        bias, noise = float(known[0].mean()), float(known[0].std())
        parts.append(f"yaw rate {1e3 * bias:.1f} +- {1e3 * noise:.1f} mrad/s")
        if abs(bias) > LARGEST_BIAS_RAD_S:
            advice.append("its yaw rate must be near 0 while nothing moves: check its unit (rad/s)")
    if len(known[1]) and len(known[2]):
        roll, pitch = float(np.median(known[1])), float(np.median(known[2]))
        parts.append(f"roll {degrees(roll):.1f}, pitch {degrees(pitch):.1f} deg")
        if max(abs(roll), abs(pitch)) > STEEPEST_RAD:
            advice.append("a robot on its feet is level: check [imu] mounting and the unit (rad)")
    if rate_hz < SLOWEST_HZ:
        advice.append(f"at least {SLOWEST_HZ:g} readings a second are of use")
    if faults:
        parts.append(faults)
        advice.append("see docs/odometry.md for the line that it has to print")
    found = ", ".join(parts)
    return warned(NAME, found, "; ".join(advice)) if advice else passed(NAME, found)
