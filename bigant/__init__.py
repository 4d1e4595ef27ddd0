"""BigANT for notebooks and scripts: ``import bigant`` gives the few calls that most work begins with.

Called by people; nothing in the project imports it. Each name is loaded when it is first used, so that the
import itself, and ``bigant --help``, cost nothing. Everything else is imported from the room where it
lives.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gap.diagnosis import diagnose as diagnose
    from gap.effect_file import UserEffect as UserEffect
    from gap.interfaces import Cause as Cause
    from gap.interfaces import Effect as Effect
    from gap.interfaces import Parameter as Parameter
    from gap.interfaces import Scope as Scope
    from model.quasistatic.frames import FrictionLaw as FrictionLaw
    from model.quasistatic.frames import solve_frames as solve_frames
    from model.systems.predict import predict as predict
    from record.log.reader import read_log as read_log
    from record.log.reader import read_ticks as read_ticks
    from robot.cli.main import run as run
    from robot.config.robot_file import load_robot as load_robot
    from robot.gap_report.trials import read_trials as read_trials
    from robot.gap_report.trials import simulator_for as simulator_for
    from robot.virtual.walk import walk_in_memory as walk_in_memory

_ROOMS = {
    "Cause": "gap.interfaces",
    "Effect": "gap.interfaces",
    "FrictionLaw": "model.quasistatic.frames",
    "Parameter": "gap.interfaces",
    "Scope": "gap.interfaces",
    "UserEffect": "gap.effect_file",
    "diagnose": "gap.diagnosis.diagnose",
    "load_robot": "robot.config.robot_file",
    "predict": "model.systems.predict",
    "read_log": "record.log.reader",
    "read_ticks": "record.log.reader",
    "read_trials": "robot.gap_report.trials",
    "run": "robot.cli.main",
    "simulator_for": "robot.gap_report.trials",
    "solve_frames": "model.quasistatic.frames",
    "walk_in_memory": "robot.virtual.walk",
}


def __getattr__(name: str) -> object:
    """Load a name from its room."""
    if name not in _ROOMS:
        raise AttributeError(f"bigant has no {name!r}; it has {', '.join(_ROOMS)}")
    value: object = getattr(import_module(_ROOMS[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the names there are."""
    return sorted(_ROOMS)
