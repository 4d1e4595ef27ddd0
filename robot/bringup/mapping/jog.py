"""``bigant servo jog``: one leg turned by a few degrees and back, to find wrong ids, signs and zeros.

Only the servo that the robot file gives to the leg gets torque. Whoever stands beside the robot says which
leg moved, and which way its foot went; what the robot file would have to say follows from that.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import TICKS_PER_TURN
from gaits.moves import LegMoves
from gaits.plan import Hold
from model.errors import BusError, ConfigError
from robot.bringup.mapping.motion import (
    GatedShafts,
    JogTrack,
    current_words,
    joined_track,
    largest,
    leg_settings,
    limp_afterwards,
)
from robot.bringup.preflight.finding import (
    Finding,
    exit_code,
    failed,
    lines_of,
    passed,
    plain_findings,
)
from robot.bringup.site import site_of, site_request
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.person import (
    BACKWARD,
    FORWARD,
    NOTHING,
    Consent,
    Hand,
    Person,
    Sight,
    Work,
)
from robot.requests.servo import ServoJogRequest

# A hand turns a shaft to mid-stance to within this.
ZERO_TOLERANCE_DEG = 8.0
# A shaft that follows lags less at rest.
LAG_TOLERANCE_DEG = 2.0
MOVE_S = 1.0
STEP_BACK_S = 2.0  # for hands to be gone
REST_S = 0.5
SEVERAL = "several"
MID_STANCE = (
    "torque is off: turn every shaft by hand to mid-stance (servo_zero: the foot at its lowest), feet "
    "in the air"
)


@dataclass(frozen=True, slots=True)
class Jog:
    """What came of turning one leg.

    Attributes:
        leg: Leg that the robot file names.
        servo_id: Id that it gives it.
        rest_ticks: Position before, with the shaft at mid-stance, within one turn [ticks].
        degrees: Angle asked for, in the leg's sense by the robot file.
        reached_deg: Angle reached, by the servo's own encoder.
        returned_deg: Angle left after the way back.
        current_a: Largest current; NaN where the servo measures none.
        moved: Leg that moved, as seen; or ``none``, ``several``.
        direction: Where its foot went first, as seen; empty where nothing moved.
    """

    leg: str
    servo_id: int
    rest_ticks: int
    degrees: float
    reached_deg: float
    returned_deg: float
    current_a: float
    moved: str
    direction: str


def jog_leg(
    port: ClockedPort,
    config: RobotConfig,
    leg: int,
    degrees: float,
    person: Person,
    keep: Callable[[str, JogTrack], None] = lambda *_: None,
) -> Jog:
    """Turn one leg and back; torque is on for about three seconds, on one servo only.

    Args:
        port: Open port of the servo bus.
        config: Robot file.
        leg: Leg index.
        degrees: How far, in the leg's sense.
        person: Watches.
        keep: Takes the leg and what its shaft did.

    Raises:
        BusError: The servo does not answer or follow; its torque is off.
        ConnectionLost: The port is gone.
    """
    settings = leg_settings(config.servo_bus, leg)
    bus = ServoBus(port, settings)
    bus.connect()
    name = settings.names[0]
    person.begins(
        Work(Hand.WATCH, f"hands off: {name} is to turn by {degrees:g} deg and back", name)
    )
    port.clock.sleep_until_ns(port.clock.now_ns() + round(STEP_BACK_S * 1e9))
    with limp_afterwards(bus):
        bus.configure()
        rest = bus.read()
        shafts = GatedShafts(bus, config)
        begin = shafts.angle_rad
        target = begin + math.radians(degrees)
        out = shafts.follow(_move(port, begin, target), MOVE_S, person.meanwhile)
        top = shafts.follow(Hold(target), REST_S, person.meanwhile)
        down = shafts.follow(_move(port, target, begin), MOVE_S, person.meanwhile)
        back = shafts.follow(Hold(begin), REST_S, person.meanwhile)
    keep(name, joined_track([out, top, down, back]))
    legs = config.servo_bus.names
    moved = person.sees(
        Sight.WHICH_LEG, f"{name} was turned: which leg moved?", (*legs, NOTHING, SEVERAL)
    )
    direction = ""
    if moved in legs:
        direction = person.sees(
            Sight.WHICH_DIRECTION, "which way did its foot go first?", (FORWARD, BACKWARD)
        )
    return Jog(
        leg=name,
        servo_id=int(settings.ids[0]),
        rest_ticks=int(rest.position_ticks[0]) % TICKS_PER_TURN,
        degrees=degrees,
        reached_deg=float(np.degrees(top.angle_rad[-1, 0] - begin[0])),
        returned_deg=float(np.degrees(back.angle_rad[-1, 0] - begin[0])),
        current_a=largest(np.concatenate([out.current_a, top.current_a])),
        moved=moved,
        direction=direction,
    )


def _move(port: ClockedPort, begin: np.ndarray, end: np.ndarray) -> LegMoves:
    start_ns = port.clock.now_ns()
    times = np.full(len(begin), start_ns, dtype=np.int64)
    return LegMoves(begin, end, times, times + round(MOVE_S * 1e9))


def jog_findings(jogs: Sequence[Jog], settings: ServoBusSettings) -> list[Finding]:
    """Compare what was seen with the robot file. Pure.

    Args:
        jogs: One a leg, of some legs or all.
        settings: What the robot file says.
    """
    findings = [_followed(jog) for jog in jogs]
    seen = {jog.moved: jog for jog in jogs if jog.moved in settings.names}
    wrong_id = [jog for jog in jogs if jog.moved in settings.names and jog.moved != jog.leg]
    turned = [jog.moved for jog in jogs if jog.moved in settings.names]
    if len(set(turned)) < len(turned):
        found = ", ".join(f"id {j.servo_id} turned {j.moved}" for j in jogs)
        advice = "two servos cannot turn one leg: repeat it, and look at one leg at a time"
        return [*findings, failed("ids", found, advice)]
    if wrong_id:
        found = ", ".join(f"id {j.servo_id} ({j.leg}) turns {j.moved}" for j in wrong_id)
        ids = _column(settings, settings.ids, {leg: j.servo_id for leg, j in seen.items()})
        findings.append(failed("ids", found, _line_words("dynamixel_id", ids)))
    measured_signs = {leg: _sign(jog, settings) for leg, jog in seen.items()}
    signs = _column(settings, settings.signs, measured_signs)
    wrong = [leg for leg, now in zip(settings.names, signs, strict=True)
             if leg in seen and now != settings.signs[settings.names.index(leg)]]  # fmt: skip
    if wrong:
        found = f"a positive angle moves the foot of {', '.join(wrong)} forward, not backward"
        findings.append(failed("signs", found, _line_words("servo_sign", signs)))
    off = {leg: _off_deg(jog, leg, settings) for leg, jog in seen.items()}
    bad = {leg: deg for leg, deg in off.items() if abs(deg) > ZERO_TOLERANCE_DEG}
    if bad:
        found = ", ".join(f"{leg} reads {deg:+.1f} deg at mid-stance" for leg, deg in bad.items())
        zeros = _column(settings, settings.zeros, {leg: seen[leg].rest_ticks for leg in bad})
        findings.append(failed("zeros", found, _line_words("servo_zero", zeros)))
    elif seen:
        most = max(off.values(), key=abs)
        findings.append(passed("zeros", f"mid-stance reads {most:+.1f} deg at most"))
    return findings


def _followed(jog: Jog) -> Finding:
    moved = (
        f"{jog.reached_deg:+.1f} of {jog.degrees:+g} deg and back to {jog.returned_deg:+.1f}, "
        f"{current_words(jog.current_a)}"
    )
    seen = f"{jog.moved} moved {jog.direction}".rstrip()
    found = f"id {jog.servo_id}: {moved}; {seen}"
    if jog.moved in {NOTHING, SEVERAL}:
        advice = "is the horn loose, or do two servos share an id? bigant devices"
        return failed(jog.leg, found, advice)
    lag = max(abs(jog.reached_deg - jog.degrees), abs(jog.returned_deg))
    if lag > LAG_TOLERANCE_DEG:
        return failed(jog.leg, f"{found}; {lag:.1f} deg off", "is the leg caught? turn it by hand")
    return passed(jog.leg, found)


def _sign(jog: Jog, settings: ServoBusSettings) -> int:
    """Return the sign of the servo that moved: its leg's sense makes the lowest foot go backward."""
    sent = int(settings.signs[settings.names.index(jog.leg)])
    right = (jog.direction == BACKWARD) == (jog.degrees > 0)
    return sent if right else -sent


def _off_deg(jog: Jog, leg: str, settings: ServoBusSettings) -> float:
    """Return by how much the leg that moved is off at mid-stance, by its zero in the robot file."""
    off = jog.rest_ticks - int(settings.zeros[settings.names.index(leg)])
    off = (off + TICKS_PER_TURN // 2) % TICKS_PER_TURN - TICKS_PER_TURN // 2
    return off * 360.0 / TICKS_PER_TURN


def _column(settings: ServoBusSettings, now: np.ndarray, found: dict[str, int]) -> list[int]:
    return [found.get(leg, int(value)) for leg, value in zip(settings.names, now, strict=True)]


def _line_words(key: str, values: Sequence[int]) -> str:
    """Say which line of the robot file is to be changed to what."""
    return f"in [legs] of the robot file: {key} = [{', '.join(map(str, values))}]"


def jog(request: ServoJogRequest) -> ExitCode:
    """Ask, turn one leg or all of them in turn, ask what moved, say what is wrong.

    Returns:
        OK when the robot file is right, VERDICT_FAILED when it is not or nothing was done.

    Raises:
        BigantError: A servo or an argument cannot be used.
    """
    config = load_robot(request.robot)
    legs = legs_of(request.leg, config.servo_bus.names)
    site = site_of(site_request(request, force_unit="none"), config)
    if not site.armed:
        raise ConfigError("--armed", "is needed: one leg is to move; hang the robot up first")
    person = site.person(yes=False, ask=False)
    words = ", ".join(config.servo_bus.names[leg] for leg in legs)
    question = f"turn {words} by {request.deg:g} deg and back, feet in the air?"
    if person.allows(question, moves=True) is not Consent.YES:
        print("nothing has been done")
        return ExitCode.VERDICT_FAILED
    person.does(Work(Hand.SET_MID_STANCE, MID_STANCE))
    port = site.wires(None).port
    if not port.openPort():
        raise BusError(f"{port.name} cannot be opened", port=port.name)
    try:
        jogs = [jog_leg(port, config, leg, request.deg, person) for leg in legs]
    finally:
        port.closePort()
    findings = jog_findings(jogs, config.servo_bus)
    result = {"jogs": [asdict(one) for one in jogs], "findings": plain_findings(findings)}
    lines = [line for finding in findings for line in lines_of(finding)]
    print_result(result, lines, as_json=request.json)
    return exit_code(findings)


def legs_of(word: str, names: Sequence[str]) -> list[int]:
    """Return the index of a leg, or of all of them.

    Raises:
        ConfigError: There is no such leg.
    """
    if word == "all":
        return list(range(len(names)))
    if word not in names:
        raise ConfigError("--leg", f"{word!r} is no leg; legs are {', '.join(names)}, or all")
    return [names.index(word)]
