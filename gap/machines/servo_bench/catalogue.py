"""The catalogue of ``servo_bench``: what a nominal servo may lack, and where the numbers go.

Ratios are neutral at 1, everything else at what the nominal servo has: added friction and inertia at 0.
``gravity_droop`` is the give of the whole position loop under its load.
"""

from dataclasses import dataclass, replace

from gap.interfaces import Effect, Parameter, Scope
from gap.machines.servo_bench.kernel import UNLIMITED_RAD_S, ServoNumbers

STAGES = ("controller", "motor", "transmission", "load", "sensing")
JOINT = (Scope.JOINT,)
ANY, IDEAL, MOTOR = "any", "ideal", "motor"
SPEED_LIMIT = Parameter(
    "limit_rad_s", "rad/s", UNLIMITED_RAD_S, 0.2, UNLIMITED_RAD_S, UNLIMITED_RAD_S / 2
)
MAY_WEAR = frozenset({
    "controller_gain", "supply_voltage", "winding_resistance", "viscous_friction", "coulomb_friction",
    "load_friction",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class BenchEffect(Effect):
    """An effect of servos.

    Attributes:
        servos: For which it means something: ``any``, ``ideal`` (no motor data) or ``motor``.
        needs: ``torque`` where it needs a known load or a measured torque, ``no load`` where it needs
            none of them; else empty.
        places: Number of ``ServoNumbers`` that a parameter changes, and how: ``+``, ``*``, ``<`` (at
            most), ``=`` or ``payload``.
    """

    servos: str
    needs: str
    places: tuple[tuple[str, str], ...]


def _number(name: str, unit: str, lower: float, upper: float, spread: float) -> Parameter:
    return Parameter(name, unit, 0.0, lower, upper, spread)


def _ratio(lower: float, upper: float, spread: float) -> tuple[Parameter, ...]:
    return (Parameter("ratio", "", 1.0, lower, upper, spread),)


def _speed(neutral: float) -> Parameter:
    return Parameter("speed_rad_s", "rad/s", neutral, 0.02, 10.0, 1.0)


def _entry(
    name: str,
    stage: str,
    parameters: tuple[Parameter, ...],
    servos: str,
    needs: str,
    places: tuple[tuple[str, str], ...],
    words: tuple[str, str],
) -> BenchEffect:
    by_forces = stage == "transmission"
    return BenchEffect(
        name, stage, parameters, JOINT, *words, servos, needs, places,
        by_forces=by_forces, wears=name in MAY_WEAR,
    )  # fmt: skip


CATALOGUE = (
    _entry("command_delay", "controller", (_number("delay_s", "s", 0.0, 0.4, 0.04),), ANY, "",
           (("delay_s", "+"),),
           ("A command acts later than it is logged.",
            "Check the bus, buffers, and the time at which commands are stamped.")),
    _entry("servo_lag", "controller", (_number("time_constant_s", "s", 0.0, 1.0, 0.06),), ANY, "",
           (("lag_s", "+"),),
           ("The position loop follows its command like a first-order low pass.",
            "Raise the position gain, or look for a profile or filter in the firmware.")),
    _entry("speed_limit", "controller", (SPEED_LIMIT,), IDEAL, "", (("speed_limit_rad_s", "<"),),
           ("The shaft cannot turn faster than this, and catches up when its command rests.",
            "Read the profile and torque limits of the servo; check the supply.")),
    _entry("controller_gain", "controller", _ratio(0.1, 5.0, 0.3), MOTOR, "", (("kp_duty_per_rad", "*"),),
           ("The position loop pushes less or more per angle of error than assumed.",
            "Read the gain registers; log the duty.")),
    _entry("duty_limit", "controller", (Parameter("limit", "", 1.0, 0.05, 1.0, 0.25),), MOTOR, "",
           (("duty_limit", "<"),),
           ("The duty cannot exceed this, so that speed and torque end early.",
            "Read the PWM and torque limits of the servo.")),
    _entry("supply_voltage", "motor", _ratio(0.4, 2.0, 0.15), MOTOR, "", (("supply_v", "*"),),
           ("The motor gets another voltage than the file says.",
            "Measure the voltage at the servo under load.")),
    _entry("torque_constant", "motor", _ratio(0.4, 2.5, 0.2), MOTOR, "", (("torque_constant_nm_a", "*"),),
           ("The motor gives another torque per ampere, and another back-EMF.",
            "Measure stall torque and no-load speed.")),
    _entry("winding_resistance", "motor", _ratio(0.4, 3.0, 0.2), MOTOR, "", (("resistance_ohm", "*"),),
           ("The winding and its driver resist more or less, hot ones more.",
            "Measure the current at stall.")),
    _entry("armature", "motor", (_number("kg_m2", "kg m^2", 0.0, 0.2, 0.01),), MOTOR, "",
           (("armature_kg_m2", "+"),),
           ("Rotor and gears have more inertia at the shaft than the file says.",
            "Fit it to a fast step without load.")),
    _entry("viscous_friction", "transmission", (_number("nm_s", "N m s", 0.0, 3.0, 0.1),), MOTOR, "",
           (("viscous_nm_s", "+"),),
           ("Friction of the gearbox grows with speed.",
            "Grease; measure no-load current at two speeds.")),
    _entry("coulomb_friction", "transmission", (_number("nm", "N m", 0.0, 2.0, 0.1),), MOTOR, "",
           (("coulomb_nm", "+"),),
           ("Dry friction of the gearbox: the loop stops short of its goal.",
            "Measure the torque at which the shaft breaks away.")),
    _entry("joint_friction", "transmission",
           (_number("nm", "N m", 0.0, 2.0, 0.1), _number("nm_s", "N m s", 0.0, 3.0, 0.1),
            _number("kg_m2", "kg m^2", 0.0, 0.2, 0.01)), MOTOR, "",
           (("coulomb_nm", "+"), ("viscous_nm_s", "+"), ("armature_kg_m2", "+")),
           ("The joint has dry friction, viscous friction and a rotor's inertia that the file leaves out.",
            "Measure the torque at which the shaft breaks away, and the current at two speeds.")),
    _entry("stribeck_friction", "transmission",
           (_number("nm", "N m", 0.0, 2.0, 0.1), _speed(0.5)), MOTOR, "",
           (("stribeck_nm", "+"), ("stribeck_rad_s", "=")),
           ("Friction is higher at rest and slow speed than when turning.",
            "Look for stick-slip in slow ramps.")),
    _entry("load_friction", "transmission", (_number("ratio", "", 0.0, 1.0, 0.1),), MOTOR, "torque",
           (("load_friction", "+"),),
           ("Gear friction grows with the load torque.",
            "Repeat with another load.")),
    _entry("stribeck_load_friction", "transmission",
           (_number("nm", "N m", 0.0, 2.0, 0.1), _speed(0.5), _number("ratio", "", 0.0, 1.0, 0.1)),
           MOTOR, "torque",
           (("stribeck_nm", "+"), ("stribeck_rad_s", "="), ("load_friction", "+")),
           ("Friction grows with the load and is higher at rest than when turning.",
            "Repeat with another load and in slow ramps.")),
    _entry("backlash", "transmission", (_number("width_rad", "rad", 0.0, 0.3, 0.02),), ANY, "torque",
           (("backlash_rad", "+"),),
           ("The shaft lies at one or the other flank of its gears' play, wherever it was last pushed.",
            "Replace the gears, or preload the joint.")),
    _entry("play", "transmission", (_number("width_rad", "rad", 0.0, 0.4, 0.03),), ANY, "",
           (("play_rad", "+"),),
           ("The shaft trails its command by half a width on either side and stays put when it turns back.",
            "Push the held shaft: that distinguishes backlash from stiction with a soft loop.")),
    _entry("payload", "load",
           (_number("mass_kg", "kg", 0.0, 5.0, 0.3), Parameter("length_m", "m", 0.1, 0.0, 0.6, 0.1)),
           MOTOR, "", (("load_kg_m", "payload"), ("load_kg_m2", "payload")),
           ("More hangs on the pendulum than the file says.",
            "Weigh it.")),
    _entry("gravity_droop", "load", (_number("rad_per_nm", "rad/(N m)", 0.0, 0.5, 0.03),), ANY, "torque",
           (("droop_rad_nm", "+"),),
           ("The shaft gives under the torque of its load.",
            "Raise the gain or add integral action.")),
    _entry("gravity_droop_unknown_load", "load",
           (_number("sin_rad", "rad", -0.5, 0.5, 0.03), _number("cos_rad", "rad", -0.5, 0.5, 0.03)),
           IDEAL, "no load", (("droop_sin_rad", "+"), ("droop_cos_rad", "+")),
           ("The shaft gives under a weight that turns with it; where it hangs straight down is not known.",
            "Raise the gain, add integral action, or give the file the load.")),
    _entry("encoder_offset", "sensing", (_number("offset_rad", "rad", -1.0, 1.0, 0.03),), ANY, "",
           (("encoder_offset_rad", "+"),),
           ("The reported angle is off by a constant.",
            "Calibrate the zero.")),
    _entry("encoder_scale", "sensing", _ratio(0.5, 1.5, 0.03), ANY, "", (("encoder_scale", "*"),),
           ("The reported angle grows by more or less than the shaft turns.",
            "Check counts per turn and the gear ratio behind the encoder.")),
)  # fmt: skip

BY_NAME = {effect.name: effect for effect in CATALOGUE}


def added(p: ServoNumbers, effect: BenchEffect, values: tuple[float, ...]) -> ServoNumbers:
    """Return a servo with a cause added; values in the order of the effect's parameters."""
    for (place, how), value in zip(effect.places, values, strict=True):
        old: float = getattr(p, place)
        if how == "payload":  # its two numbers belong together
            mass, length = values
            new = old + mass * length ** (2 if place == "load_kg_m2" else 1)
        else:
            new = {"+": old + value, "*": old * value, "<": min(old, value), "=": value}[how]
        p = p._replace(**{place: new})
    return p


MOTOR_CONSTANTS = ("supply_voltage", "torque_constant", "winding_resistance")


def with_alike(effect: BenchEffect, logged: frozenset[str]) -> BenchEffect:
    """Return an effect with those that it is indistinguishable from, as far as the loop was logged.

    The shaft sees gain, voltage, torque constant and resistance as one product; the duty parts the gain
    from the motor, the current the voltage from the winding.

    Args:
        effect: Of the catalogue.
        logged: Fields of a trial that were measured, of ``pwm`` and ``current_a``.
    """
    group: tuple[str, ...] = ()
    if not logged:
        group, tells = ("controller_gain", *MOTOR_CONSTANTS), "log the duty (pwm_J) or the current"
    elif "pwm" not in logged:
        group, tells = ("controller_gain", "supply_voltage"), "log the duty (pwm_J)"
    if effect.name not in group:
        return effect
    return replace(effect, alike=tuple(one for one in group if one != effect.name), tells=tells)
