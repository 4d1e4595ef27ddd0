"""The gait of a run: a gait of the robot file or of a Python file, one that the servos can follow."""

import time
from math import tau

import numpy as np

from drivers.dynamixel.units import TICKS_PER_TURN
from gaits.catalog import make_gait
from gaits.gait import Gait
from gaits.limits import check_gait
from gaits.plugin import PluginGait
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig
from robot.console.program_output import complain
from robot.control.safety import ENDING_TICK
from robot.requests.single import DriveRequest

# A gait that takes more of a tick than this is worth a warning; measured on so many phases.
SLOW_SHARE, SLOW_SAMPLES = 0.2, 31


def gait_of(request: DriveRequest, config: RobotConfig) -> tuple[RobotConfig, str, float]:
    """Return the robot with the gait, its name and frequency; without a name if it is only listened to.

    Raises:
        ConfigError: There is no such gait.
        GaitRefused: The servos cannot follow it.
    """
    if request.readonly and request.gait is None and not config.parameters.gaits:
        return config, "", request.frequency_hz or 0.0
    config, name = with_gait(config, request.gait)
    gait = make_gait(name, config.parameters)
    frequency_hz = request.frequency_hz if request.frequency_hz is not None else gait.frequency_hz
    check_gait(gait, frequency_hz, config.parameters.servo)
    cycles = request.cycles
    if cycles is None:
        cycles = (request.duration_s or 0.0) * frequency_hz
    note = turns_note(gait, cycles)
    if note:
        complain(f"warning: {note}")
    if isinstance(gait, PluginGait) and not request.virtual_time:
        _note_slow_gait(gait, 1 / (request.rate_hz or config.loop.rate_hz))
    return config, name, frequency_hz


def _note_slow_gait(gait: Gait, period_s: float) -> None:
    """Say if a gait of a Python file takes much of a tick."""
    spent_s = []
    for phase in np.linspace(0.0, 1.0, SLOW_SAMPLES):
        began = time.perf_counter()
        gait.motion(float(phase), 0.0)
        spent_s.append(time.perf_counter() - began)
    usual_s = float(np.median(spent_s))
    if usual_s > SLOW_SHARE * period_s:
        complain(
            f"warning: {gait.name} takes {usual_s * 1e3:.1f} of {period_s * 1e3:g} ms of each tick; the "
            "robot stops if ticks come late"
        )


def turns_note(gait: Gait, cycles: float) -> str:
    """Say that a walk is too long for the servos' turn counters; empty where it is not.

    Args:
        gait: Its gait.
        cycles: How many of them are asked for.
    """
    begin, end = (gait.motion(phase, 0.0).angle_rad for phase in (0.0, 1.0))
    a_cycle = float(np.abs(end - begin).max()) / tau
    last = ENDING_TICK / TICKS_PER_TURN
    if a_cycle * cycles <= last:
        return ""
    return (
        f"{cycles:g} cycles turn a shaft by {a_cycle * cycles:.0f} turns, and a servo's counter has "
        f"{last:.0f} at most: the walk will end on all feet before (TURNS_USED); start it again then"
    )
