"""The gait of a run: a gait of the robot file or of a Python file, one that the servos can follow."""

import time

import numpy as np

from gaits.catalog import make_gait
from gaits.gait import Gait
from gaits.limits import check_gait
from gaits.plugin import PluginGait
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig
from robot.console.program_output import complain
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
