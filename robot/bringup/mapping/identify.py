"""``bigant force identify``: press each foot, and see which transducer feels it, along which of its axes.

Three presses a foot (up, forward, left) give the transducer's number, whether its z axis points up, and its
yaw. Nothing is switched on; a press is noticed by itself, and so is its end.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from drivers.ati.foot_forces import sensed_wrenches
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import Clock
from model.errors import ForceStreamError
from model.values.arrays import FloatArray
from robot.bringup.mapping.jog import legs_of
from robot.bringup.preflight.finding import (
    Finding,
    exit_code,
    failed,
    lines_of,
    passed,
    plain_findings,
    warned,
)
from robot.bringup.site import site_of, site_request
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.person import Hand, Person, Work
from robot.requests.force import ForceIdentifyRequest
from robot.run.force_unit import require_sensors, started

PRESSES = (
    (Hand.PRESS_UP, "up"),
    (Hand.PRESS_FORWARD, "forward"),
    (Hand.PRESS_LEFT, "to the robot's left"),
)
# A hand presses harder than this, and has let go below that [N].
PRESSED_N = 6.0
FREE_N = 2.0
STEADY_S = 0.3
PATIENCE_S = 60.0
LOOK_NS = 10_000_000
# A hand presses in a direction to within this.
DIRECTION_TOLERANCE_DEG = 25.0
YAW_TOLERANCE_DEG = 20.0


@dataclass(frozen=True, slots=True)
class Press:
    """One press of one foot.

    Attributes:
        leg: Leg that was pressed.
        hand: Direction.
        transducer: Transducer that felt most of it; 0 for none in time.
        force_n: Change of its force, its own axes, (3,) [N].
        others_n: Largest change of any other transducer [N].
    """

    leg: str
    hand: Hand
    transducer: int
    force_n: tuple[float, float, float]
    others_n: float


class PressedFeet:
    """Reads the stream while a person presses feet.

    Args:
        stream: Running.
        settings: Its settings.
        clock: Its clock.
        person: Presses.
    """

    def __init__(
        self, stream: ForceStream, settings: ForceSensorSettings, clock: Clock, person: Person
    ) -> None:
        self._stream, self._settings = stream, settings
        self._clock, self._person = clock, person

    def identify(self, leg: int) -> list[Press]:
        """Have one foot pressed in three directions.

        Raises:
            ForceStreamError: The unit falls silent.
        """
        return [self._press(leg, hand, direction) for hand, direction in PRESSES]

    def _press(self, leg: int, hand: Hand, direction: str) -> Press:
        name = self._settings.names[leg]
        rest = self._steady(lambda change: bool(change.max() < FREE_N), np.zeros(1), PATIENCE_S)
        if rest is None:
            raise ForceStreamError("the feet do not come to rest: let go of all of them")
        work = Work(
            hand, f"{name}: press its foot {direction} with about 1 kg, and keep pressing", name
        )
        self._person.begins(work)
        felt = self._steady(lambda change: bool(change.max() > PRESSED_N), rest, PATIENCE_S)
        self._person.begins(Work(Hand.LET_GO, f"{name}: let go", name))
        if felt is None:
            return Press(name, hand, 0, (0.0, 0.0, 0.0), 0.0)
        change = felt - rest
        sizes = np.linalg.norm(change, axis=1)
        most = int(np.nanargmax(sizes))
        others = np.delete(sizes, most)
        x, y, z = change[most].tolist()
        self._steady(lambda change: bool(change.max() < FREE_N), rest, PATIENCE_S)
        return Press(
            name, hand, int(self._settings.transducers[most]), (x, y, z),
            float(np.nanmax(others, initial=0.0)),
        )  # fmt: skip

    def _steady(
        self, holds: Callable[[FloatArray], bool], rest: FloatArray, limit_s: float
    ) -> FloatArray | None:
        """Return the mean forces, (N, 3), once a condition on their change has held for a while.

        Args:
            holds: The condition, given the change of each transducer's force, (N,) [N].
            rest: What changes count from, (N, 3); without it they count from the readings' own mean.
            limit_s: How long to wait for that.
        """
        clock, began_ns = self._clock, self._clock.now_ns()
        kept: list[FloatArray] = []
        since_ns = last_ns = began_ns
        while (now_ns := clock.now_ns()) - began_ns < limit_s * 1e9:
            clock.sleep_until_ns(now_ns + LOOK_NS)
            self._person.meanwhile((clock.now_ns() - began_ns) * 1e-9)
            for record in self._stream.read():
                last_ns = clock.now_ns()
                forces = sensed_wrenches(record, self._stream.calibrations, self._settings)[:, :3]
                before = rest if rest.ndim == 2 else np.mean([*kept, forces], axis=0)
                change = np.nan_to_num(np.linalg.norm(forces - before, axis=1))
                if not holds(change):
                    kept, since_ns = [], clock.now_ns()
                    continue
                kept.append(forces)
            if kept and clock.now_ns() - since_ns >= STEADY_S * 1e9:
                mean: FloatArray = np.mean(kept, axis=0)
                return mean
            if clock.now_ns() - last_ns > 1e9:
                raise ForceStreamError("the force-torque unit sends no more records")
        return None


def press_findings(presses: Sequence[Press], settings: ForceSensorSettings) -> list[Finding]:
    """Compare what was felt with the robot file. Pure.

    Args:
        presses: Three of each leg that was pressed.
        settings: What the robot file says.
    """
    findings: list[Finding] = []
    numbers, yaws = settings.transducers.tolist(), settings.yaw_rad.tolist()
    ups = settings.up.tolist()
    wrong_number, wrong_up, wrong_yaw = [], [], []
    for leg, name in enumerate(settings.names):
        mine = {press.hand: press for press in presses if press.leg == name}
        if not mine:
            continue
        felt = _felt(name, mine)
        findings.append(felt.finding)
        if felt.number and felt.number != numbers[leg]:
            wrong_number.append(
                f"the foot of {name} presses transducer {felt.number}, not {numbers[leg]}"
            )
            numbers[leg] = felt.number
        if felt.up and felt.up != ups[leg]:
            wrong_up.append(f"z of {name} points {'up' if felt.up > 0 else 'down'}")
            ups[leg] = felt.up
        off_deg = _wrapped_deg(felt.yaw_rad - yaws[leg]) if felt.up else 0.0
        if abs(off_deg) > YAW_TOLERANCE_DEG:
            wrong_yaw.append(f"{name} by {off_deg:+.0f} deg")
            yaws[leg] = round(felt.yaw_rad, 2)
    if wrong_number:
        line = f"in [legs] of the robot file: transducer = [{', '.join(map(str, numbers))}]"
        findings.append(failed("transducers", "; ".join(wrong_number), line))
    if wrong_up:
        line = f"in [force_sensor] of the robot file: up = [{', '.join(map(str, ups))}]"
        findings.append(failed("sensor up", "; ".join(wrong_up), line))
    if wrong_yaw:
        line = f"in [force_sensor] of the robot file: yaw = [{', '.join(f'{y:g}' for y in yaws)}]"
        findings.append(failed("sensor yaw", f"turned about z: {', '.join(wrong_yaw)}", line))
    return findings


@dataclass(frozen=True, slots=True)
class _Felt:
    """What three presses of one foot say.

    Attributes:
        finding: In words.
        number: Transducer, 0 if unclear.
        up: +1 where its z axis points up, -1 where it points down, 0 if unclear.
        yaw_rad: Its yaw, where ``up`` is known.
    """

    finding: Finding
    number: int = 0
    up: int = 0
    yaw_rad: float = 0.0


def _felt(name: str, mine: dict[Hand, Press]) -> _Felt:
    """Judge one leg."""
    numbers = {press.transducer for press in mine.values()}
    words = ", ".join(f"{_direction(h)} {_force_words(p)}" for h, p in mine.items())
    if numbers == {0}:
        return _Felt(
            failed(name, "no transducer measured it", "is it switched on? bigant force watch")
        )
    if len(numbers) != 1:
        found = f"measured by transducers {', '.join(map(str, sorted(numbers)))}: {words}"
        return _Felt(failed(name, found, "press that foot only, and again: --leg " + name))
    number = numbers.pop()
    up, forward, left = (
        np.array(mine[hand].force_n) / np.linalg.norm(mine[hand].force_n) for hand, _ in PRESSES
    )
    found = f"transducer {number}: {words}"
    if np.degrees(np.arccos(np.clip(abs(up[2]), 0, 1))) > DIRECTION_TOLERANCE_DEG:
        advice = "press straight up once more, or its z axis is not upright and no key can say so"
        return _Felt(failed(name, f"{found}; up is not along its z", advice), number)
    if np.linalg.det([forward, left, up]) < 0:
        advice = "no mounting does that: is a sign of its matrix wrong? CAL on the unit's console"
        found += "; it gives the force of the leg, not on it"
        return _Felt(failed(name, found, advice), number)
    which = 1 if up[2] > 0 else -1
    forward, left = forward * (1, which, which), left * (1, which, which)
    directions = np.array([forward[0] + left[1], left[0] - forward[1]])
    yaw_rad = float(np.arctan2(directions[1], directions[0]))
    spread = np.degrees(np.arccos(np.clip(np.linalg.norm(directions) / 2, 0, 1)))
    found += f"; z {'up' if which > 0 else 'down'}, yaw {np.degrees(yaw_rad):+.0f} deg"
    if spread > DIRECTION_TOLERANCE_DEG:
        found += f", forward and left {spread:.0f} deg apart from a right angle"
        advice = "press straight forward and straight left once more: --leg " + name
        return _Felt(warned(name, found, advice), number, which, yaw_rad)
    return _Felt(passed(name, found), number, which, yaw_rad)


def _force_words(press: Press) -> str:
    return "(" + " ".join(f"{value:+.1f}" for value in press.force_n) + ") N"


def _direction(hand: Hand) -> str:
    return hand.name.removeprefix("PRESS_").lower()


def _wrapped_deg(angle_rad: float) -> float:
    return float(np.degrees(np.remainder(angle_rad + np.pi, 2 * np.pi) - np.pi))


def identify(request: ForceIdentifyRequest) -> ExitCode:
    """Have feet pressed and say what that means.

    Returns:
        OK when the robot file is right, VERDICT_FAILED when it is not.

    Raises:
        BigantError: The unit or an argument cannot be used.
    """
    config = load_robot(request.robot)
    settings = config.force_sensor
    require_sensors(settings)
    site = site_of(site_request(request, hardware=request.hardware or "unused"), config)
    person = site.person(yes=True, ask=False)
    wires = site.wires(None)
    if wires.links is None:
        raise ForceStreamError("there is no force-torque unit to read")
    with started(ForceStream(*wires.links(), wires.unit, wires.clock)) as stream:
        feet = PressedFeet(stream, settings, wires.clock, person)
        presses = [p for leg in legs_of(request.leg, settings.names) for p in feet.identify(leg)]
    findings = press_findings(presses, settings)
    result = {
        "presses": [{**asdict(press), "hand": _direction(press.hand)} for press in presses],
        **plain_findings(findings),
    }
    lines = [line for finding in findings for line in lines_of(finding)]
    print_result(result, lines, as_json=request.json)
    return exit_code(findings)
