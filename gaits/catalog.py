"""Which gaits there are."""

from gaits.buehler import BuehlerTripod
from gaits.gait import Gait
from gaits.metachronal import Metachronal
from gaits.names import GAIT_NAMES, METACHRONAL, TRIPOD
from model.errors import ConfigError
from model.values.parameters import RobotParameters


def make_gait(name: str, robot: RobotParameters) -> Gait:
    """Build a gait by name.

    Raises:
        ConfigError: There is no such gait, or its parameters make none.
    """
    if name == TRIPOD:
        return BuehlerTripod(robot.tripod, robot.legs)
    if name == METACHRONAL:
        return Metachronal(robot.metachronal, robot.legs)
    raise ConfigError("gait", f"{name!r} is no gait; choose {' or '.join(GAIT_NAMES)}")
