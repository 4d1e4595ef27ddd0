"""BigANT for notebooks and scripts: ``import bigant`` gives the few calls that most work begins with.

Called by people; nothing in the project imports it. Each name is loaded when it is first used, so that the
import itself, and ``bigant --help``, cost nothing. It does what the commands do, by the same functions.
Everything else is imported from its own package. ``docs/notebook.md`` shows all of them at work.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING

from bigant.name_conflict import NameConflict as NameConflict
from bigant.name_conflict import check_names

if TYPE_CHECKING:
    from bigant.diagnosis import GapReport as GapReport
    from bigant.diagnosis import diagnose as diagnose
    from bigant.logs import Log as Log
    from bigant.logs import import_table as import_table
    from bigant.logs import read_log as read_log
    from bigant.pictures import Picture as Picture
    from bigant.pictures import plot as plot
    from bigant.prediction import predict as predict
    from bigant.prediction import sample_gait as sample_gait
    from bigant.tracks import Odometry as Odometry
    from bigant.tracks import odometry as odometry
    from bigant.walks import walk as walk
    from bigant.walks import walk_trial as walk_trial
    from model.errors import BigantError as BigantError
    from robot.cli.main import run as run
    from robot.config.robot_file import RobotConfig as RobotConfig
    from robot.config.robot_file import load_robot as load_robot

_MODULES = {
    "BigantError": "model.errors",
    "GapReport": "bigant.diagnosis",
    "Log": "bigant.logs",
    "Odometry": "bigant.tracks",
    "Picture": "bigant.pictures",
    "RobotConfig": "robot.config.robot_file",
    "diagnose": "bigant.diagnosis",
    "import_table": "bigant.logs",
    "load_robot": "robot.config.robot_file",
    "odometry": "bigant.tracks",
    "plot": "bigant.pictures",
    "predict": "bigant.prediction",
    "read_log": "bigant.logs",
    "run": "robot.cli.main",
    "sample_gait": "bigant.prediction",
    "walk": "bigant.walks",
    "walk_trial": "bigant.walks",
}
_COMMANDS = {
    "-m",
    "bigant",
    "bigant.exe",
}  # they check the names themselves: one line, no traceback

if not TYPE_CHECKING:  # to a type checker the names above are all

    def __getattr__(name: str) -> object:
        """Load a name from its module."""
        if name not in _MODULES:
            raise AttributeError(f"bigant has no {name!r}; it has {', '.join(__dir__())}")
        check_names()
        value = getattr(import_module(_MODULES[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    """Return the names there are."""
    return sorted({"NameConflict", *_MODULES})


if sys.argv[:1] and sys.argv[0].replace("\\", "/").rpartition("/")[2] not in _COMMANDS:
    check_names()
