"""``bigant replay LOG --drive``: the recorded wishes again on a robot, and what it measures now.

The wishes go through today's controller and safety gate as any operator's do; recorded angles are never
sent as they are. Real hardware has to be armed, and its ids, zeros, limits and rate come from the robot
file of this computer (or --robot), never from the log.
"""

import sys
from bisect import bisect_right
from collections.abc import Mapping
from contextlib import ExitStack, redirect_stdout
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from model.errors import ConfigError, RecordError
from model.parameters.toml_table import parse_toml
from model.values.faults import StopReason
from model.values.tick import Intent, Request, Tick
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_tick_messages, sound
from record.log.tick_message import decode_inputs
from record.whole_file import check_room
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.program_output import complain
from robot.console.progress import ProgressLine
from robot.console.table import Column, number_text, row_lines, table_lines
from robot.control.controller import Controller
from robot.drive.drive import check_hardware, drive_as, usual_log
from robot.replay.repeat import Repeat, compare_runs, overlay
from robot.replay.repeat_plots import draw_repeat
from robot.replay.ticks import imported
from robot.report.pictures import write_report
from robot.report.run_date import date_words
from robot.requests.recorded import ReplayRequest
from robot.requests.single import VIRTUAL, DriveRequest
from robot.run.operator import Interrupts
from robot.run.rebuilt import rebuild_controller

PAGES = (".html", ".png")
NUMBERS = ("sent mrad", "shaft mrad", "current A", "Fx N", "Fy N", "Fz N")
LEG_COLUMNS = (Column("leg"), *(Column(name, ".3f") for name in NUMBERS))


@dataclass(frozen=True, slots=True)
class Wishes:
    """The operator's wishes of a run.

    Attributes:
        times_ns: When each first came, since the first tick.
        requests: The wishes.
        end_ns: When the run ended.
    """

    times_ns: tuple[int, ...]
    requests: tuple[Request, ...]
    end_ns: int


class RecordedOperator:
    """An operator that repeats the recorded wishes; stops at the end, and at any Ctrl-C.

    Args:
        wishes: The recorded wishes.
        interrupts: Come first.
    """

    def __init__(self, wishes: Wishes, interrupts: Interrupts) -> None:
        self._wishes = wishes
        self._interrupts = interrupts
        self._start_ns: int | None = None

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        """Return the wish for the tick at ``t_ns``."""
        if self._start_ns is None:
            self._start_ns = t_ns
        since_ns = t_ns - self._start_ns
        number = bisect_right(self._wishes.times_ns, since_ns) - 1
        wish = self._wishes.requests[number]
        if since_ns > self._wishes.end_ns and wish.intent not in {Intent.STOP, Intent.CUT}:
            wish = Request(
                Intent.STOP, wish.gait, wish.frequency_hz, wish.steer, StopReason.COMPLETED
            )
        return self._interrupts.override(wish)


def read_wishes(path: Path, contents: LogContents) -> Wishes:
    """Read the operator's wishes of a run.

    Raises:
        RecordError: The log cannot be read, or does not begin with tick 0.
    """
    times: list[int] = []
    requests: list[Request] = []
    start_ns = now_ns = 0
    for number, message in enumerate(read_tick_messages(path, contents)):
        with sound(path, message):
            recorded = decode_inputs(message.data, message.layout)
        if recorded.index != number:
            break
        start_ns = recorded.t_ns if number == 0 else start_ns
        now_ns = recorded.t_ns
        if not requests or recorded.inputs.request != requests[-1]:
            times.append(now_ns - start_ns)
            requests.append(recorded.inputs.request)
    if not requests:
        raise RecordError(f"{path} holds no tick 0; a run is repeated from its beginning")
    return Wishes(tuple(times), tuple(requests), now_ns - start_ns)


def drive_again(request: ReplayRequest) -> ExitCode:
    """Do a run again, compare, print, draw.

    Raises:
        BigantError: The log cannot be read, or something is wrong before the robot moves.
    """
    contents = LogContents()
    with ProgressLine(f"reading {request.path}", contents.progress):
        wishes = read_wishes(request.path, contents)
    if imported(contents):
        raise RecordError(
            f"{request.path} is imported data: no operator of ours walked it, so no wish can be repeated; "
            "a robot that is driven walks by bigant drive"
        )
    real = request.hardware != VIRTUAL
    # ids, zeros, limits, rate and watchdog of real servos are not taken from a log, whose ever it is
    path = request.robot or (DEFAULT_ROBOT_FILE if real else None)
    own = None if path is None else load_robot(path)
    then = rebuild_controller(contents, own, request.gait).controller
    if real and own is not None:
        for line in differences(contents.config_text, own.text, str(path)):
            complain(f"bigant replay: {line}")
    if not then.armed:
        raise RecordError(f"{request.path} was recorded without torque: it has nothing to repeat")
    first = wishes.requests[0]
    new = DriveRequest(
        gait=first.gait,
        frequency_hz=first.frequency_hz,
        steer=first.steer,
        hardware=request.hardware,
        force_unit=request.force_unit,
        armed=True,
        rate_hz=then.config.loop.rate_hz if real else then.rate_hz,
        virtual_time=request.virtual_time,
        seed=request.seed,
    )
    check_hardware(new)
    if real and not request.armed:
        raise ConfigError(
            "--hardware",
            "does the run again with torque: put the robot where it can walk, add --armed",
        )
    check_room(request.out, "--out", *PAGES)
    new_log = request.log or usual_log(f"{request.path.stem}-again")
    if new_log.resolve() == request.path.resolve():
        raise ConfigError("--log", "is the old log itself; choose another file")
    page = request.out or new_log.with_suffix(".html")

    def operator(_: Controller, interrupts: Interrupts, __: ExitStack) -> RecordedOperator:
        return RecordedOperator(wishes, interrupts)

    with redirect_stdout(sys.stderr if request.json else sys.stdout):
        code = drive_as(new, then.config, new_log, operator)
    _compare(request, new_log, page)
    return code


def differences(recorded: str, used: str, name: str) -> list[str]:
    """Return where the robot file to be used differs from the one in the log, a line each."""
    now = flat(parse_toml(used, "robot file"))
    then = flat(parse_toml(recorded, "robot file in the log"))
    return [
        f"{key} is {now.get(key, 'not given')} in {name}, and was {then.get(key, 'not given')} in the run"
        for key in sorted({*then, *now})
        if then.get(key) != now.get(key)
    ]


def flat(table: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return a TOML table with dotted keys."""
    values: dict[str, Any] = {}
    for key, value in table.items():
        values |= (
            flat(value, f"{above}{key}.") if isinstance(value, dict) else {f"{above}{key}": value}
        )
    return values


def _compare(request: ReplayRequest, new_log: Path, page: Path) -> None:
    """Compare both runs, print and draw."""
    old, new = read_log(request.path), read_log(new_log)
    both = overlay(old, new)
    result = compare_runs(old, new, both)
    dates = (date_words(old.metadata), date_words(new.metadata))
    runs = f"{request.path} (old, {dates[0]}) and {new_log} (new, {dates[1]})"
    rows = [*leg_rows(result), *body_rows(result)]
    pictures = write_report(page, f"{request.path.name} again", runs, rows, draw_repeat(both),
                             repeat_sentence(result))  # fmt: skip
    if request.json:
        files = {"old_log": request.path, "new_log": new_log, "pictures": pictures}
        print_json(asdict(result) | files)
        return
    for line in (*leg_table(result), *row_lines(body_rows(result))):
        print(line)
    print("pictures: " + ", ".join(str(path) for path in pictures))


def repeat_sentence(result: Repeat) -> str:
    """Return how far apart both runs end, in one sentence."""
    apart = np.subtract(result.new_way, result.old_way)
    if not np.isfinite(apart).all():
        return f"{result.duration_s:.1f} s of both runs are compared; where one ended is not known."
    mm, deg = 1e3 * float(np.hypot(*apart[:2])), float(np.degrees(abs(apart[2])))
    return (
        f"After {result.duration_s:.1f} s the new run is {mm:.1f} mm and {deg:.1f} deg from where the old "
        "one was."
    )


def leg_table(result: Repeat) -> list[str]:
    """Return the differences of the legs as a table."""
    rows = [
        (leg.name, leg.sent_rad * 1e3, leg.angle_rad * 1e3, leg.current_a, *leg.force_n)
        for leg in result.legs
    ]
    return ["RMS of new - old", *table_lines(LEG_COLUMNS, rows)]


def leg_rows(result: Repeat) -> list[tuple[str, str]]:
    """Return the differences of the legs as labels and texts, for a page."""
    return [
        (
            f"{leg.name}, RMS of new - old",
            f"sent {_shown(leg.sent_rad * 1e3)} mrad, shaft {_shown(leg.angle_rad * 1e3)} mrad, "
            f"current {_shown(leg.current_a)} A, force "
            + ", ".join(f"{axis} {_shown(f)}" for axis, f in zip("xyz", leg.force_n, strict=True))
            + " N",
        )
        for leg in result.legs
    ]


def body_rows(result: Repeat) -> list[tuple[str, str]]:
    """Return the body's part of the comparison: label and text."""
    return [
        (
            "compared",
            f"{result.duration_s:.1f} s of {result.old_s:.1f} s old, {result.new_s:.1f} s new",
        ),
        ("true velocity, RMS of new - old", _velocity(result.true_velocity)),
        ("predicted velocity, RMS of new - old", _velocity(result.predicted_velocity)),
        ("displacement, old", _displacement(result.old_way)),
        ("displacement, new", _displacement(result.new_way)),
        ("dead reckoning, old", _displacement(result.old_reckoned_way)),
        ("dead reckoning, new", _displacement(result.new_reckoned_way)),
    ]


def _shown(value: float) -> str:
    return number_text(value, 3)  # NaN: not measured


def _velocity(values: tuple[float, ...]) -> str:
    vx, vy, yaw = (_shown(value * 1e3) for value in values)
    return f"vx {vx}, vy {vy} mm/s, yaw rate {yaw} mrad/s"


def _displacement(values: tuple[float, ...]) -> str:
    forward, left, turn = values
    return f"forward {_shown(forward)} m, left {_shown(left)} m, turned {_shown(turn)} rad"
