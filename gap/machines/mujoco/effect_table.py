"""What a joint of an MJCF machine may lack: one row an effect, bounds as shares of the joint's own scale.

Words on physics are those of ``servo_bench`` where the effect is the same.
"""

from dataclasses import dataclass

from gap.machines.mujoco.drive import CURRENT, FIRMWARE, POSITION, TORQUE
from gap.machines.servo_bench.catalogue import CATALOGUE as BENCH
from gap.machines.servo_bench.catalogue import MAY_WEAR, SPEED_LIMIT
from model.effects.causes import Effect, Parameter, Scope

CONTROLLER, MOTOR, TRANSMISSION, LOAD, SENSING = STAGES = (
    "controller", "motor", "transmission", "load", "sensing",
)  # fmt: skip
JOINT, BODY, WORLD = "joint", "body", "world"
ONE, SAME = (Scope.JOINT,), (Scope.ALL, Scope.JOINT)
LOOPS, ALL_KINDS = (POSITION, FIRMWARE), (POSITION, FIRMWARE, TORQUE, CURRENT)
# What a parameter is a share of: nothing, the joint's usual torque, its inertia, one over its torque.
PLAIN, OF_TORQUE, OF_INERTIA, PER_TORQUE = "", "torque", "inertia", "per torque"
# What a row needs besides a kind of drive.
DAMPED, LIMITED, TORQUES, SPEEDS = "kd", "limit", "torques", "speeds"
WORDS = {one.name: (one.physics, one.remedy) for one in BENCH}
# Effects that are another form of the same cause: a joint lies by its torque, or by how it moves.
FORM_OF = {"backlash": "play"}


@dataclass(frozen=True, slots=True)
class MjcfEffect(Effect):
    """An effect of rigid bodies and their drives.

    Attributes:
        acts_on: ``joint``, ``body`` or ``world``.
        places: Number that each parameter changes, and how: ``+``, ``*``, ``<`` (at most) or ``=``.
    """

    acts_on: str
    places: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class JointRow:
    """An effect of joints.

    Attributes:
        effect: With bounds and spreads in shares of ``sizes``.
        sizes: What each parameter is a share of.
        kinds: Drives that can have it.
        needs: What the drive or the logs must have besides; empty for nothing.
        each: Whether there is also one of every joint with numbers of its own.
    """

    effect: MjcfEffect
    sizes: tuple[str, ...]
    kinds: tuple[str, ...]
    needs: str
    each: bool


def share(name: str, unit: str, spread: float, most: float) -> Parameter:
    """Return a number that is 0 if nothing happens, and never negative."""
    return Parameter(name, unit, 0.0, 0.0, most, spread)


def ratio(lower: float, upper: float, spread: float) -> tuple[Parameter, ...]:
    """Return the one number of an effect that multiplies."""
    return (Parameter("ratio", "", 1.0, lower, upper, spread),)


def _row(
    name: str,
    stage: str,
    *numbers: tuple[Parameter, tuple[str, str], str],
    kinds: tuple[str, ...] = ALL_KINDS,
    needs: str = "",
    scopes: tuple[Scope, ...] = ONE,
    each: bool = False,
    words: tuple[str, str] | None = None,
) -> JointRow:
    parameters, places, sizes = zip(*numbers, strict=True)
    physics, remedy = words or WORDS[name]
    by_forces = stage == TRANSMISSION
    effect = MjcfEffect(
        name, stage, parameters, scopes, physics, remedy, JOINT, places,
        by_forces=by_forces, wears=name in MAY_WEAR, form_of=FORM_OF.get(name, ""),
        rough=float(FORM_OF.get(name, name) == "play"),  # how a joint crosses it differs from gear to gear
    )  # fmt: skip
    return JointRow(effect, sizes, kinds, needs, each)


Number = tuple[Parameter, tuple[str, str], str]
COULOMB: Number = (share("coulomb_nm", "N m", 0.2, 2.0), ("coulomb_nm", "+"), OF_TORQUE)
VISCOUS: Number = (share("viscous_nm_s", "N m s", 0.05, 2.0), ("viscous_nm_s", "+"), OF_TORQUE)
ARMATURE: Number = (
    share("armature_kg_m2", "kg m^2", 4.0, 60.0),
    ("armature_kg_m2", "+"),
    OF_INERTIA,
)
STICK: Number = (share("nm", "N m", 0.1, 2.0), ("stribeck_nm", "+"), OF_TORQUE)
SLOW = Parameter("speed_rad_s", "rad/s", 0.5, 0.02, 10.0, 1.0)


def _times(place: str, lower: float, upper: float, spread: float) -> Number:
    return ratio(lower, upper, spread)[0], (place, "*"), PLAIN


JOINT_EFFECTS = (
    _row("coulomb_friction", TRANSMISSION, COULOMB, each=True),
    _row("viscous_friction", TRANSMISSION, VISCOUS, each=True),
    _row("armature", MOTOR, ARMATURE, each=True),
    _row(
        "joint_friction", TRANSMISSION, COULOMB, VISCOUS, ARMATURE, each=True,
        words=(
            "Drive and gears at the joint: dry and viscous friction, and the inertia of the rotor.",
            "Put frictionloss, damping and armature into the model; identify them at one joint alone.",
        ),
    ),
    _row("stribeck_friction", TRANSMISSION, STICK, (SLOW, ("stribeck_rad_s", "="), PLAIN)),
    _row("load_friction", TRANSMISSION, (share("ratio", "", 0.1, 1.0), ("load_friction", "+"), PLAIN),
         each=True),
    _row("play", TRANSMISSION, (share("width_rad", "rad", 0.02, 0.4), ("play_rad", "+"), PLAIN),
         kinds=LOOPS, each=True),
    _row("backlash", TRANSMISSION,
         (share("width_rad", "rad", 0.02, 0.4), ("backlash_rad", "+"), PLAIN), kinds=LOOPS,
         words=(
             "The joint lies at one or the other flank of its gears' play, whichever way it is driven.",
             WORDS["backlash"][1],
         )),
    _row(
        "compliance", TRANSMISSION,
        (share("rad_per_nm", "rad/(N m)", 0.01, 0.3), ("compliance_rad_nm", "+"), PER_TORQUE),
        kinds=LOOPS, each=True,
        words=(
            "Gears or belts between encoder and body give under torque.",
            "Hold the joint and push it; measure the angle on both sides.",
        ),
    ),
    _row("command_delay", CONTROLLER, (share("delay_s", "s", 0.02, 0.4), ("delay_s", "+"), PLAIN),
         kinds=LOOPS, scopes=SAME),
    _row("servo_lag", CONTROLLER, (share("time_constant_s", "s", 0.03, 0.5), ("lag_s", "+"), PLAIN),
         kinds=LOOPS, scopes=SAME),
    _row("speed_limit", CONTROLLER, (SPEED_LIMIT, ("speed_limit_rad_s", "<"), PLAIN),
         kinds=LOOPS, scopes=SAME),
    _row("controller_gain", CONTROLLER, _times("kp", 0.1, 5.0, 0.3), kinds=LOOPS, scopes=SAME),
    _row(
        "damping_gain", CONTROLLER, _times("kd", 0.0, 5.0, 0.3), kinds=LOOPS, needs=DAMPED, scopes=SAME,
        words=("The loop damps less or more than thought.", "Read the gain registers."),
    ),
    _row("duty_limit", CONTROLLER, (Parameter("limit", "", 1.0, 0.05, 1.0, 0.25), ("limit", "<"), PLAIN),
         kinds=(FIRMWARE,)),
    _row(
        "torque_limit", CONTROLLER, _times("limit", 0.02, 1.0, 0.25), kinds=(POSITION,), needs=LIMITED,
        words=("The drive gives no more than a share of its limit.",
               "Read the limits of current and torque."),
    ),
    _row(
        "motor_strength", MOTOR, _times("strength", 0.1, 5.0, 0.2), kinds=(POSITION,), scopes=SAME,
        words=(
            "The motor gives a multiple of the torque that its loop asks for, gains and limit alike.",
            "Hang a known weight on the joint; check supply, motor constant and gear ratio.",
        ),
    ),
    _row("supply_voltage", MOTOR, _times("supply_v", 0.4, 2.0, 0.15), kinds=(FIRMWARE,), scopes=SAME),
    _row("winding_resistance", MOTOR, _times("resistance_ohm", 0.4, 3.0, 0.2), kinds=(FIRMWARE,),
         scopes=SAME),
    _row("torque_constant", MOTOR, _times("torque_constant_nm_a", 0.2, 5.0, 0.2),
         kinds=(FIRMWARE, CURRENT), scopes=SAME, each=True),
    _row(
        "torque_scale", SENSING, _times("torque_scale", 0.2, 5.0, 0.2), needs=TORQUES,
        scopes=SAME, each=True,
        words=(
            "Logged torque is a multiple of the torque at the joint.",
            "Check the torque constant and the gear ratio by which the log was made.",
        ),
    ),
    _row(
        "encoder_offset", SENSING,
        (Parameter("offset_rad", "rad", 0.0, -0.5, 0.5, 0.03), ("encoder_offset_rad", "+"), PLAIN),
        each=True,
    ),
    _row("encoder_scale", SENSING, _times("encoder_scale", 0.5, 1.5, 0.03), kinds=LOOPS, scopes=SAME),
    _row(
        "speed_scale", SENSING, _times("speed_scale", -1000.0, 1000.0, 5.0), needs=SPEEDS, scopes=SAME,
        words=(
            "Logged speed is a multiple of the joint's: another unit, or the motor's side of the gears.",
            "Divide by the ratio where the log is made.",
        ),
    ),
)  # fmt: skip
