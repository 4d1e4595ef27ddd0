"""Whether the legs of a robot can stand where its gaits have them stand."""

import numpy as np

from model.errors import ConfigError
from model.values.parameters import CrankParameters, PluginParameters, RobotParameters

QUARTER_TURN = np.pi / 2


def check_stance(parameters: RobotParameters) -> None:
    """Refuse gaits in whose stance a crank points level or up: it cannot stand there.

    Raises:
        ConfigError: One of the gaits has such a stance; with its leg and angles.
    """
    if not isinstance(parameters.leg, CrankParameters):
        return
    for gait in parameters.gaits:
        if isinstance(gait, PluginParameters):
            continue  # Python says where it turns the legs: robot show walks it
        farthest = np.abs(gait.offset) + gait.stance_sweep / 2
        leg = int(np.argmax(farthest))
        if farthest[leg] >= QUARTER_TURN:
            raise ConfigError(
                f"gait.{gait.name}.stance_sweep",
                f"turns {parameters.legs.names[leg]} to {np.degrees(farthest[leg]):.0f} deg from "
                "straight down in stance, and a crank stands within 90 deg only; make the sweep or "
                "the offset smaller",
            )
