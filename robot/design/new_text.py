"""The text of a new robot file: commented, and of a robot that stands about its centre of mass."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from drivers.dynamixel.servo_model import ServoModel
from gaits.gait import leg_sides
from model.kinematics.four_bar import linkage_pose
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import FourBarParameters, LegParameters

FOUR_BAR, CRANK = "four_bar", "crank"
# The four-bar of the nominal robot for a foot 1 m below its shaft; a new one is this one scaled.
NOMINAL_DEPTH_M = 0.1312756
NOMINAL = FourBarParameters(
    crank=0.030, ground_pivot=np.array([-0.090, 0.103]), coupler=0.132, rocker=0.044,
    foot=np.array([0.011, 0.147]), branch=1, mid_stance=5.2779,
)  # fmt: skip
ASSUMED = ", assumed"
ROOM, LONGEST = 32, 104  # letters of a line before its comment, and of all of it
MOST_TRANSDUCERS = 6  # of one wireless unit
HOT_C = 80
BUS = [
    "[servo_bus]",
    "baud_rate = 1000000",
    "watchdog = 0.24                  # s: a servo without requests for so long stops by itself",
    "silent_limit = 5                 # reads in a row without an answer before the robot stops",
]
LOOP = [
    "[loop]",
    "rate = 100                       # Hz, up to 200",
    "late_limit = 0.005               # s: a tick later than this counts as late",
    "late_ticks = 20                  # late ticks in a row before the robot stops",
]
LEGS_SHARE = 0.5  # of the mass, with their servos
SINK_SHARE = 0.03  # of the leg's length, under a third of the weight
TORQUE_SHARE, SPEED_SHARE, CURRENT_SHARE = 0.45, 0.85, 0.75  # of stall, no load, stall
SWEEP = {FOUR_BAR: 2.0943951, CRANK: 0.6981317}  # of a stance: 120 and 40 degrees
MAX_ACCELERATION = 40.0  # rad/s^2
SPEED_USED, ACCELERATION_USED = 0.5, 0.5  # of the limits, by the gaits of a new file
MOST_HZ = 0.3
CRAWL_DUTY = 0.92


@dataclass(frozen=True, slots=True, kw_only=True)
class NewRobot:
    """What a new robot file is made from.

    Attributes:
        name: Name of the robot.
        legs: Number of legs, at least 4.
        leg: ``four_bar`` or ``crank``.
        servo: Model of its servos.
        leg_length_m: Foot below shaft in mid-stance.
        length_m: Hind to front feet.
        width_m: Left to right feet.
        mass_kg: Of all of it.
        force_sensors: Whether its legs have them.
        given: Names of the sizes that are known; the others are marked as assumed.
    """

    name: str
    legs: int
    leg: str
    servo: ServoModel
    leg_length_m: float
    length_m: float
    width_m: float
    mass_kg: float
    force_sensors: bool
    given: frozenset[str] = frozenset()

    def mark(self, size: str, words: str) -> str:
        """Return a comment, with a mark where the size is not known."""
        return words if size in self.given or words.endswith(ASSUMED) else f"{words}{ASSUMED}"


@dataclass(frozen=True, slots=True)
class _Gait:
    """One gait of a new file: touchdowns in the order of the legs, duty and frequency."""

    name: str
    words: str
    touchdown: FloatArray
    duty: float
    blend: float

    def frequency_hz(self, sweep: float, max_speed: float) -> float:
        """Return a frequency that stays well below the servo's speed and acceleration [Hz]."""
        fast = (2 * math.pi - sweep) / (1 - self.duty)
        corner = (fast - sweep / self.duty) / self.blend
        by_acceleration = math.sqrt(ACCELERATION_USED * MAX_ACCELERATION / corner)
        highest = min(MOST_HZ, SPEED_USED * max_speed / fast, by_acceleration)
        return float(f"{highest:.2g}")


def robot_text(new: NewRobot) -> str:
    """Return the text of a robot file."""
    names, feet = places(new)
    shafts = feet - [foot_offset_m(new), 0.0]
    count, weight = new.legs, new.mass_kg * STANDARD_GRAVITY
    stiffness = float(f"{weight / 3 / (SINK_SHARE * new.leg_length_m):.2g}")
    legs = LegParameters(names, np.column_stack([shafts, np.zeros(count)]))
    sink = f"{100 * SINK_SHARE:.0f} % of the leg's length under a third of the weight"
    head = [
        f"# Robot file of {new.name}, begun with bigant robot new.",
        '# Values marked "assumed" are stand-ins: replace them by what you measure. How it walks as it is:',
        "#   bigant robot show FILE",
        "# Units: m, kg, N, rad, s. Frames: REP-103 (x forward, y left, z up).",
        "# An unknown or missing key is an error, so that a typing mistake cannot pass for a default.",
        "",
        _key("name", _text(new.name)),
    ]
    contact = [
        "[contact]",
        _key("stiffness", _row([stiffness] * count), f"N/m, vertical, assumed: {sink}"),
        _key("mu", _row([0.6] * count), "assumed"),
        _key("anisotropy", _row([[0, 0]] * count)),
    ]
    blocks = [
        head, _body(new, feet), _legs(new, legs), _leg(new), contact, _servo(new.servo), BUS,
        *([_force_sensor(count)] if new.force_sensors else []), LOOP,
        *(_gait_table(one, new) for one in gaits(new, legs)),
    ]  # fmt: skip
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def places(new: NewRobot) -> tuple[tuple[str, ...], FloatArray]:
    """Return names of the legs and their feet seen from the centre of mass, (N, 2) [m].

    An even number stands in pairs from hind to front, left before right; an odd one on an oval, the
    first leg in front.
    """
    half_length, half_width = new.length_m / 2, new.width_m / 2
    if new.legs % 2:
        turn = 2 * np.pi * np.arange(new.legs) / new.legs
        oval = np.column_stack([half_length * np.cos(turn), half_width * np.sin(turn)])
        side = new.legs // 2
        names = ["F", *(f"L{k + 1}" for k in range(side)), *(f"R{side - k}" for k in range(side))]
        return tuple(names), oval
    rows = new.legs // 2
    x = np.linspace(-half_length, half_length, rows)
    ends = {2: "HF", 3: "HMF"}.get(rows)
    names = [
        f"{ends[row]}{side}" if ends else f"{side}{row + 1}" for side in "LR" for row in range(rows)
    ]
    y = np.repeat([half_width, -half_width], rows)
    return tuple(names), np.column_stack([np.tile(x, 2), y])


def scaled_four_bar(depth_m: float) -> FourBarParameters:
    """Return the nominal four-bar with its foot so far below the shaft."""
    scale = depth_m / NOMINAL_DEPTH_M
    return FourBarParameters(
        crank=_digits(NOMINAL.crank * scale),
        ground_pivot=np.array([_digits(one * scale) for one in NOMINAL.ground_pivot]),
        coupler=_digits(NOMINAL.coupler * scale),
        rocker=_digits(NOMINAL.rocker * scale),
        foot=np.array([_digits(one * scale) for one in NOMINAL.foot]),
        branch=NOMINAL.branch,
        mid_stance=NOMINAL.mid_stance,
    )


def foot_offset_m(new: NewRobot) -> float:
    """Return how far ahead of its shaft a foot is in the middle of its stance [m]."""
    if new.leg == CRANK:
        return 0.0
    stance = np.linspace(-0.5, 0.5, 31) * SWEEP[FOUR_BAR]
    x = linkage_pose(scaled_four_bar(new.leg_length_m), stance).foot[:, 0]
    return float((x.min() + x.max()) / 2)


def gaits(new: NewRobot, legs: LegParameters) -> list[_Gait]:
    """Return gaits that suit the number of legs."""
    count = new.legs
    made = []
    if count >= 6 and count % 2 == 0:
        rows = count // 2
        row, left = np.arange(count) % rows, leg_sides(legs) > 0
        touchdown = np.where((row % 2 == 0) == left, 0.0, 0.5)
        words = "every other leg, then the others"
        made.append(_Gait("tripod" if count == 6 else "alternating", words, touchdown, 0.6, 0.02))
    if count == 4:
        made.append(_crawl())
    else:
        made.append(_wave(count))
    return made


def _crawl() -> _Gait:
    """The wave gait of four legs: a front foot lifts when the hind foot of its side has come down.

    McGhee and Frank 1968, doi 10.1016/0025-5564(68)90090-4: of all, it keeps farthest from tipping.
    """
    duty = CRAWL_DUTY
    return _Gait(
        "crawl", "one foot at a time", np.array([0, 1 - duty, 0.5, 1.5 - duty]), duty, 0.01
    )


def _wave(count: int) -> _Gait:
    """One foot at a time: from hind to front on the left, then on the right."""
    # an odd number goes round the oval by every other leg: neighbours do not follow each other
    step = (count + 1) // 2 if count % 2 else 1
    order = (np.arange(count) * step) % count
    return _Gait("wave", "one foot at a time", order / count, round(1 - 0.8 / count, 3), 0.01)


def block_and_legs(new: NewRobot, feet: FloatArray) -> list[float]:
    """Return moments of inertia about the centre of mass, (3,) [kg m^2]: a flat block, and legs.

    Args:
        new: The robot.
        feet: Its feet from above, (N, 2) [m].
    """
    across = np.ptp(feet, axis=0)
    size = np.array([*across, max(new.leg_length_m, 0.3 * across.max())])
    corners = np.column_stack([feet, np.full(new.legs, -new.leg_length_m / 2)])
    block, legs = (1 - LEGS_SHARE) / 12 * size**2, LEGS_SHARE * (corners**2).mean(axis=0)
    along = new.mass_kg * (block + legs)  # sum of mass times place squared, along each axis
    moments: list[float] = (along.sum() - along).tolist()
    return moments


def _body(new: NewRobot, feet: FloatArray) -> list[str]:
    moments = block_and_legs(new, feet)
    inertia = _row([_digits(one, 3) for one in moments])
    return [
        "[body]",
        _key("mass", f"{new.mass_kg:g}", new.mark("mass", "kg")),
        _key(
            "inertia",
            inertia,
            "Ixx, Iyy, Izz about the centre of mass, assumed: block and legs",
        ),
        "# the body frame's origin is at the centre of mass, at the height of the shafts",
    ]


def _legs(new: NewRobot, legs: LegParameters) -> list[str]:
    count = legs.count
    right = legs.shaft_position[:, 1] < -1e-9
    places = new.mark(
        "length", new.mark("width", "the feet stand about the centre of mass with it")
    )
    transducers = [k + 1 if k < MOST_TRANSDUCERS else 0 for k in range(count)]
    sensors = _key(
        "transducer", _row(transducers), "ATI wireless transducer, 1-based; 0 = none; assumed"
    )
    return [
        "[legs]",
        _key("order", _row(legs.names)),
        _key("dynamixel_id", _row(range(1, count + 1)), "assumed"),
        *([sensors] if new.force_sensors else []),
        f"# shaft in the body frame; {places}",
        "shaft_position = [",
        *(f"  {_row([_digits(x), _digits(y), 0.0])},   # {name}"
          for name, (x, y, _) in zip(legs.names, legs.shaft_position.tolist(), strict=True)),
        "]",
        "# +1: increasing servo position turns the shaft so that a foot in stance moves backward;",
        "# assumed: right-hand servos are mirrored. Look with bigant servo jog",
        _key("servo_sign", _row(np.where(right, -1, 1).tolist())),
        _key("servo_zero", _row([2048] * count), "ticks at shaft angle 0, assumed; bigant servo zero"),
    ]  # fmt: skip


def _leg(new: NewRobot) -> list[str]:
    head = "[leg]                            # all legs alike, each in its own x-z plane"
    if new.leg == CRANK:
        radius = "of the half circle that rolls (C-leg), assumed; 0: a straight leg"
        return [
            head,
            _key(
                "kind", _text(CRANK), "fixed to the servo's shaft, straight down at shaft angle 0"
            ),
            _key(
                "length", f"{_digits(new.leg_length_m):g}", new.mark("leg_length", "shaft to toe")
            ),
            _key("radius", f"{_digits(new.leg_length_m / 2):g}", radius),
        ]
    bar = scaled_four_bar(new.leg_length_m)
    return [
        f"{head}; assumed: BigANT's, scaled",
        _key("kind", _text(FOUR_BAR), "a crank on the servo, a coupler with the foot, a rocker"),
        _key("crank", f"{bar.crank:g}"),
        _key(
            "ground_pivot", _row(bar.ground_pivot.tolist()), "rocker pivot from the shaft, (x, z)"
        ),
        _key("coupler", f"{bar.coupler:g}", "crank pin A to rocker pin B"),
        _key("rocker", f"{bar.rocker:g}"),
        _key("foot", _row(bar.foot.tolist()), "in the coupler frame: along A->B, and to its left"),
        _key(
            "branch", f"{bar.branch}", "B lies to the left of the line from A to the ground pivot"
        ),
        _key("mid_stance", f"{bar.mid_stance:g}", "rad, crank from +x towards +z at shaft angle 0"),
    ]


def _servo(model: ServoModel) -> list[str]:
    ratings, stall = model.ratings, f"{100 * TORQUE_SHARE:.0f} % of the stall torque"
    shutdown = model.table["temperature_limit"].initial or HOT_C
    fast = f"rad/s, assumed: {100 * SPEED_SHARE:.0f} % of the speed without load"
    least = _digits(max(0.85 * ratings.voltage_v, model.lowest_voltage_v), 2)
    torque = _digits(TORQUE_SHARE * ratings.stall_torque_n_m, 2)
    lines = [
        "[servo]",
        _key("model", _text(model.name)),
        _key("supply_voltage", f"{ratings.voltage_v:g}", "V"),
        _key("rated_torque_limit", f"{torque:g}", f"N m, assumed: {stall}"),
        _key("max_speed", f"{max_speed(model):g}", fast),
        _key("max_acceleration", f"{MAX_ACCELERATION:g}", "rad/s^2, assumed"),
        _key("max_temperature", f"{shutdown - 10:g}", "degC, assumed: ten below its own shutdown"),
        _key("min_voltage", f"{least:g}", "V, assumed"),
    ]
    if model.measures_current:
        current = min(CURRENT_SHARE * ratings.stall_current_a, 0.99 * model.highest_current_a)
        lines.append(_key("max_current", f"{_digits(current, 2):g}", "A, assumed: below stall"))
    error = "rad between the shaft and its command, assumed"
    return [*lines, _key("max_following_error", "0.6", error)]


def max_speed(model: ServoModel) -> float:
    """Return the speed that a new file allows a servo [rad/s]."""
    return _digits(
        min(SPEED_SHARE * model.ratings.no_load_rad_s, 0.99 * model.highest_speed_rad_s), 2
    )


def _force_sensor(count: int) -> list[str]:
    nothing = _row([[0.0, 0.0, 0.0]] * count)
    return [
        "[force_sensor]                   # ATI wireless F/T (WNet), at most six transducers",
        _key("address", _text("192.168.0.3"), "the unit's factory address"),
        _key("udp_port", "49152"),
        _key("console_port", "23"),
        _key("local_port", "49152", "keep it fixed: another needs a power cycle of the unit"),
        _key("rate", "100", "packets a second"),
        _key("oversampling", "32"),
        _key("silent_limit", "0.5", "s without a record before the robot stops"),
        _key("offset", nothing, "place relative to the shaft, assumed"),
        _key("yaw", _row([0.0] * count), "rad from body to sensor axes, assumed"),
        _key("bias", nothing, "N, reading without contact; bigant force bias"),
    ]


def _gait_table(gait: _Gait, new: NewRobot) -> list[str]:
    sweep = SWEEP[new.leg]
    touchdown = _row([_digits(one) for one in gait.touchdown.tolist()])
    return [
        f"{f'[gait.{gait.name}]':<32} # {gait.words}",
        _key("kind", _text("phases")),
        _key(
            "frequency", f"{gait.frequency_hz(sweep, max_speed(new.servo)):g}", "Hz, assumed: slow"
        ),
        _key("touchdown", touchdown, "share of the cycle, one a leg"),
        _key("duty", f"{gait.duty:g}", "share of the cycle in stance, assumed"),
        _key("stance_sweep", f"{sweep:.7g}", "rad of shaft angle in stance, assumed"),
        _key("blend", f"{gait.blend:g}", "share of the cycle over which speed changes are spread"),
    ]


def _key(key: str, value: str, comment: str = "") -> str:
    """Return a line; its comment stands behind it where there is room, else above."""
    text = f"{f'{key} = {value}':<{ROOM}}"
    if not comment:
        return text.rstrip()
    both = f"{text} # {comment}"
    return both if len(both) <= LONGEST else f"# {comment}\n{text}"


def _digits(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}") + 0.0


def _text(text: str) -> str:
    import tomlkit  # quotes as TOML has them

    return tomlkit.string(text).as_string()


def _row(values: Iterable[object]) -> str:
    return f"[{', '.join(_cell(one) for one in values)}]"


def _cell(value: object) -> str:
    if isinstance(value, str):
        return _text(value)
    return _row(value) if isinstance(value, list) else repr(value)
