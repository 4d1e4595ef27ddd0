"""What a step of the first day works with, and what it leaves: findings, measured facts, raw bytes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from drivers.dynamixel.bus import ServoBus
from drivers.wire.tap import WireTap
from model.values.wire import Wire, WireBytes
from record.log.header import RunHeader
from robot.bringup.first_day.curve import DayCurve
from robot.bringup.preflight.finding import CheckVerdict, Finding
from robot.bringup.site import Site
from robot.config.robot_file import RobotConfig
from robot.console.person import Person
from robot.run.rig import Wires

FactValue = bool | int | float | str
KeepBytes = Callable[[tuple[WireBytes, ...]], None]


@dataclass(frozen=True, slots=True)
class Fact:
    """Something about the devices that was an assumption and is now measured.

    Attributes:
        table: Table of the scenario file: ``servo``, ``force_unit`` or ``adapter`` (``sim_hw.assumed``).
        key: Key in it.
        value: Its value.
        how: How it was measured, one sentence with its figures.
    """

    table: str
    key: str
    value: FactValue
    how: str


@dataclass(frozen=True, slots=True)
class DayOptions:
    """How thorough the day is.

    Attributes:
        loop_s: How long the loop runs without torque [s].
        reboots: Reboots of each servo.
        frequency_hz: Cycles a second of the walks, None for the gait's own.
    """

    loop_s: float
    reboots: int
    frequency_hz: float | None = None


@dataclass(slots=True)
class Day:
    """One step of the day while it runs.

    Attributes:
        config: Robot file.
        site: The robot.
        person: Whoever stands next to it.
        options: How thorough.
        folder: Where files of the step go.
        log: The step's log.
        tell: Called with each finding as it comes.
        keep_bytes: Takes raw bytes, oldest first.
        tap: Listens in on all wires of the step.
        findings: What has been found.
        facts: What has been settled.
        curves: What each leg did, for the page.
    """

    config: RobotConfig
    site: Site
    person: Person
    options: DayOptions
    folder: Path
    log: Path
    tell: Callable[[Finding], None]
    keep_bytes: KeepBytes
    tap: WireTap = field(default_factory=WireTap)
    findings: list[Finding] = field(default_factory=list)
    facts: list[Fact] = field(default_factory=list)
    curves: list[DayCurve] = field(default_factory=list)

    def note(self, *findings: Finding) -> None:
        """Take findings."""
        for finding in findings:
            self.findings.append(finding)
            self.tell(finding)
        self.heard()

    def settled(self, table: str, key: str, value: FactValue, how: str) -> None:
        """Take a measured fact."""
        self.facts.append(Fact(table, key, value, how))

    def heard(self) -> tuple[WireBytes, ...]:
        """Return what has passed on the wires since the last call; it is kept in the step's log."""
        pieces = self.tap.take()
        self.keep_bytes(pieces)
        return pieces

    def wires(self) -> Wires:
        """Return the robot's wires with the step's tap on all of them, not open."""
        wires = self.site.wires(self.tap)
        self.tap.listen(wires.port)
        return wires

    def bus(self) -> ServoBus:
        """Return the servo bus, not yet open."""
        wires = self.wires()
        return ServoBus(wires.port, self.config.servo_bus)


def run_header(config: RobotConfig, site: Site) -> RunHeader:
    """Return the header of a log of the day."""
    return RunHeader(
        robot=config.name, hardware=site.name, time="virtual" if site.virtual else "real"
    )


def worst(findings: list[Finding]) -> CheckVerdict:
    """Return the verdict of several findings."""
    for verdict in (CheckVerdict.FAIL, CheckVerdict.WARN, CheckVerdict.PASS):
        if any(finding.verdict is verdict for finding in findings):
            return verdict
    return CheckVerdict.SKIP


def received(pieces: tuple[WireBytes, ...], wire: Wire) -> bytes:
    """Return what came in on a wire."""
    return b"".join(piece.data for piece in pieces if piece.wire is wire and not piece.sent)
