"""The table ``[safety]`` of a robot file, all of which may be left out: older files load as ever.

What each key means and its default stand here and nowhere else.
"""

import math
from dataclasses import dataclass, fields

from drivers.dynamixel.registers import HardwareError
from model.errors import ConfigError
from model.parameters.toml_table import Table


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Limits on what the body does, beside those on each servo.

    Attributes:
        max_tilt: Largest lean of the body against the ground, by the model's support and by the direction
            of the sum of all measured forces [rad].
        tilt_time: It must last so long [s].
        stall_current: A shaft that does not follow its goal with more current than this is stalled [A].
        stall_time: Time over which goal and shaft are compared [s].
        stall_travel: The goal must have moved at least so far in it [rad].
        max_slip: Way that dead reckoning may find while the robot stands still [m].
        max_distance: Way from where the run began; infinite without the key [m].
        min_load: Share of the weight that the measured forces must add up to.
        unloaded_time: Less than that must last so long [s].
    """

    max_tilt: float = 0.35
    tilt_time: float = 0.2
    stall_current: float = 1.5
    stall_time: float = 0.5
    stall_travel: float = 0.08
    max_slip: float = 0.05
    max_distance: float = math.inf
    min_load: float = 0.3
    unloaded_time: float = 0.3


@dataclass(frozen=True, slots=True)
class RecoverySettings:
    """Whether a servo that lost its torque may be brought back while the robot holds.

    Attributes:
        most: Recoveries of all servos together within ``window``; 0 (no such table) allows none.
        window: [s].
        wait: How long a silent servo is waited for before it counts as lost [s].
        causes: Hardware errors that may be rebooted away.
        after_restart: Whether a servo that lost its power may be switched on again.
    """

    most: int = 0
    window: float = 300.0
    wait: float = 1.0
    causes: HardwareError = HardwareError.OVERLOAD
    after_restart: bool = False


def read_body_limits(table: Table) -> BodyLimits:
    """Read the limits that are in a table; the others have their defaults.

    Raises:
        ConfigError: A limit makes no sense.
    """
    highest = {"max_tilt": math.pi / 2, "min_load": 0.95}
    given = {
        one.name: table.number(one.name, above=0, maximum=highest.get(one.name, math.inf))
        for one in fields(BodyLimits)
        if table.has(one.name)
    }
    return BodyLimits(**given)


def read_recovery(table: Table) -> RecoverySettings:
    """Read ``[safety.recovery]``; without it nothing is recovered.

    Raises:
        ConfigError: A key makes no sense.
    """
    usual = RecoverySettings()
    if not table.has("recovery"):
        return usual
    recovery = table.table("recovery")
    return RecoverySettings(
        most=recovery.integer("most", minimum=1, maximum=100),
        window=recovery.number("window", above=0, otherwise=usual.window),
        wait=recovery.number("wait", above=0, otherwise=usual.wait),
        causes=_causes(recovery) if recovery.has("causes") else usual.causes,
        after_restart=recovery.flag("after_restart", otherwise=usual.after_restart),
    )


def _causes(table: Table) -> HardwareError:
    causes = HardwareError(0)
    for name in table.texts("causes"):
        try:
            causes |= HardwareError[name.upper()]
        except KeyError:
            known = ", ".join(str(error.name).lower() for error in HardwareError)
            raise ConfigError(
                table.name("causes"), f"{name!r} is no hardware error; there are {known}"
            ) from None
    return causes
