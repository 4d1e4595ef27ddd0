"""Steps 10 and 11: each foot pressed, and the force-torque unit's console read without writing anything."""

import re
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from drivers.ati.console import Console
from drivers.ati.links import TextLink
from drivers.ati.packets import Malformed, UnitCommand, parse_command, parse_datagram
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.ati.unit_state import STATE_COMMANDS, UnitState, read_unit_state
from drivers.clock import Clock
from model.motion.se2 import turned
from model.values.readings import ForceRecord
from model.values.wire import Wire, WireBytes
from record.whole_file import write_text
from robot.bringup.first_day.curve import DayCurve
from robot.bringup.first_day.day import Day
from robot.bringup.mapping.identify import PRESSES, Press, PressedFeet, press_findings
from robot.bringup.preflight.finding import Finding, failed, passed, skipped, warned
from robot.bringup.preflight.forces import calibration_findings
from robot.run.force_unit import started, why_no_unit
from robot.run.rig import Wires

CONSOLE_FILE = "console.txt"
# Bits of the first status word that ATI's pages do not explain.
UNKNOWN_BITS = 0xC0C0_F000
# What is pressed with: about 1 kg.
ABOUT_N = 9.8
PRESS_LABEL = "1 up, 2 forward, 3 left"
QUIET_S = 0.3
GREETING_S = 1.0
LONGEST_S = 3.0
FIRST_STREAM_NS = 500_000_000
LOOK_NS = 10_000_000


def feet(day: Day) -> None:
    """Step 10: press each foot up, forward and left."""
    wires = day.wires()
    if wires.links is None:
        day.note(skipped("force unit", why_no_unit(day.config.force_sensor)))
        return
    pieces = list(_short_stream(day, wires))
    with started(ForceStream(*wires.links(), wires.unit, wires.clock)) as stream:
        pressed = PressedFeet(stream, wires.unit, wires.clock, day.person)
        presses = []
        for leg, number in enumerate(wires.unit.transducers.tolist()):
            if number:
                presses += pressed.identify(leg)
                pieces += day.heard()
    day.curves.extend(press_curves(presses, wires.unit))
    day.note(*press_findings(presses, wires.unit))
    _stream_facts(day, (*pieces, *day.heard()))


def press_curves(presses: Sequence[Press], settings: ForceSensorSettings) -> list[DayCurve]:
    """Return how hard each foot was pressed along each direction, by yaw and up of the robot file. Pure."""
    curves = []
    along = {hand: axis for axis, (hand, _) in zip((2, 0, 1), PRESSES, strict=True)}
    for name, yaw, up in zip(settings.names, settings.yaw_rad, settings.up, strict=True):
        mine = [press for press in presses if press.leg == name and press.transducer]
        measured = []
        for press in mine:
            x, y, z = np.array(press.force_n) * (1, up, up)
            body = (*turned(x, y, float(yaw)), z)
            measured.append(round(float(body[along[press.hand]]), 2))
        number = tuple(float([hand for hand, _ in PRESSES].index(press.hand) + 1) for press in mine)
        if mine:
            expected = (ABOUT_N,) * len(mine)
            curves.append(
                DayCurve(name, PRESS_LABEL, "force [N]", number, tuple(measured), expected)
            )
    return curves


def _short_stream(day: Day, wires: Wires) -> tuple[WireBytes, ...]:
    """Start and stop the stream once, so that the next start can be compared with this one."""
    assert wires.links is not None
    with started(ForceStream(*wires.links(), wires.unit, wires.clock)) as stream:
        end_ns = wires.clock.now_ns() + FIRST_STREAM_NS
        while wires.clock.now_ns() < end_ns:
            wires.clock.sleep_until_ns(wires.clock.now_ns() + LOOK_NS)
            stream.read()
    return day.heard()


def _stream_facts(day: Day, pieces: tuple[WireBytes, ...]) -> None:
    """Settle what records and commands on the wire tell of the unit."""
    datagrams = [piece for piece in pieces if piece.wire is Wire.FORCE_DATAGRAMS]
    commands = [piece.data for piece in datagrams if piece.sent]
    echoed = [piece for piece in datagrams if not piece.sent and piece.data in commands]
    how = f"{len(commands)} commands, {len(echoed)} came back"
    day.settled("force_unit", "acknowledges", bool(echoed), how)
    day.note(passed("commands", how))
    runs: list[list[ForceRecord]] = [[]]
    for piece in datagrams:
        if piece.sent:
            command = parse_command(piece.data)
            if command is not None and command.command == UnitCommand.START and runs[-1]:
                runs.append([])
            continue
        parsed = parse_datagram(piece.data, piece.t_ns)
        if not isinstance(parsed, Malformed):
            runs[-1] += parsed
    records = [record for run in runs for record in run]
    if not records:
        return
    bits = 0
    for record in records:
        bits |= int(record.status[0]) & UNKNOWN_BITS
    day.settled("force_unit", "extra_status", bits, f"{len(records)} records")
    levels = sorted({record.battery for record in records})
    day.settled("force_unit", "battery", levels[-1], f"{len(records)} records; seen {levels}")
    words = f"unknown status bits 0x{bits:08X}, battery byte {', '.join(map(str, levels))}"
    if len(runs) > 1 and runs[0] and runs[1]:
        last, first = runs[0][-1].sequence, runs[1][0].sequence
        again = first < last
        how = f"last sequence number before a stop {last}, first after the next start {first}"
        day.settled("force_unit", "sequence_restarts", again, how)
        words += "; a start " + ("sets the sequence back" if again else "counts on")
    day.note(passed("records", words))


def console(day: Day) -> None:
    """Step 11: read the console; nothing is set."""
    wires = day.wires()
    if wires.links is None:
        day.note(skipped("force unit", why_no_unit(day.config.force_sensor)))
        return
    with ExitStack() as stack:
        datagrams, text = wires.links()
        stack.callback(datagrams.close)
        stack.callback(text.close)
        greeting = _until_quiet(text, wires.clock, GREETING_S)
        text.write(b"\r\n")
        empty = _until_quiet(text, wires.clock, QUIET_S)
        text.write(b"VERSIONS\r\n")
        versions = _until_quiet(text, wires.clock, QUIET_S)
        day.heard()
        talk = KeptConsole(text, wires.clock)
        state = read_unit_state(talk)
        calibrations, _ = calibration_findings(talk, wires.unit)
    _console_facts(day, greeting, empty, versions)
    day.note(*calibrations)
    for command in STATE_COMMANDS:
        day.note(_judged(command, talk.answers[command], state, wires.unit))
    parts = [f"# {name}\n{answer}\n" for name, answer in talk.answers.items()]
    write_text(day.folder / CONSOLE_FILE, "\n".join(parts), "--folder")
    day.note(passed("kept", f"{CONSOLE_FILE}: {len(parts)} answers; each byte in the step's log"))


class KeptConsole(Console):
    """A console that keeps its answers, by command; those to CAL by transducer."""

    def __init__(self, link: TextLink, clock: Clock) -> None:
        super().__init__(link, clock)
        self.answers: dict[str, str] = {}
        self._transducer = ""

    def query(self, command: str) -> str:
        """Send a command, keep its answer and return it."""
        answer = super().query(command)
        if command.startswith("TRANS "):
            self._transducer = command.removeprefix("TRANS ")
            return answer
        name = f"CAL of transducer {self._transducer}" if command == "CAL" else command
        self.answers[name] = answer
        return answer


def _until_quiet(text: TextLink, clock: Clock, quiet_s: float) -> bytes:
    """Return what is printed until nothing more comes for a while."""
    heard, end_ns = b"", clock.now_ns() + round(LONGEST_S * 1e9)
    while clock.now_ns() < end_ns and (data := text.read(quiet_s)):
        heard += data
    return heard


def _console_facts(day: Day, greeting: bytes, empty: bytes, versions: bytes) -> None:
    plain = re.sub(rb"\xff(?:[\xfb-\xfe].|.)", b"", greeting)  # telnet options
    day.settled("force_unit", "banner", bool(plain.strip()), f"{len(greeting)} bytes when opened")
    if empty.isascii():
        line = empty.decode("ascii")
        day.settled("force_unit", "empty_line", line, "one empty line, CR LF")
    blank = re.search(rb"\r?\n\r?\n>\s*$", versions) is not None
    day.settled("force_unit", "blank_line", blank, "the end of the answer to VERSIONS")
    words = (
        f"{'greets' if plain.strip() else 'does not greet'}; an empty line gives {empty!r}; "
        f"{'a' if blank else 'no'} blank line before the prompt"
    )
    day.note(passed("console", words))


def _judged(command: str, answer: str, state: UnitState, settings: ForceSensorSettings) -> Finding:
    """Judge one answer: what would change the data, and is not ours."""
    lines = [line.strip() for line in answer.splitlines() if line.strip()]
    short = " | ".join(" ".join(line.split()) for line in lines if not line.startswith("--"))
    concerns = "; ".join(words for about, words in state.concerns(settings) if about == command)
    if concerns:
        return (failed if command == "XPWR" else warned)(command, short, concerns)
    if command == "RATE":
        wanted = f"a run sets {settings.rate_hz} Hz, oversampling {settings.oversampling}"
        return passed(command, f"{short}; {wanted}")
    return passed(command, short)
