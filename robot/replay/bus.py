"""``bigant replay LOG --bus``: recorded bytes through today's drivers, hardware in the loop without it.

The devices are a tape (``sim_hw.host.recorded_wire``). The drivers connect, configure, read and send as
they do on a robot, the controller runs on what they read, and everything they send must be what was
recorded.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.setup import free_console
from drivers.wire.words import difference_words, wire_name, wire_words
from model.errors import BusError, ForceStreamError, RecordError
from model.values.faults import Fault, FaultKind
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log.reader import LogContents, read_ticks, read_wires
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.control.safety import Allowed
from robot.replay.compare import ComparedRun, Comparison
from robot.replay.fields import FIELDS, WIRE_FIELDS
from robot.run.hardware import assemble
from robot.run.header import FORCE_UNIT_KEY, LATENCY_KEY
from robot.run.loop import exchange
from robot.run.rebuilt import Rebuilt, rebuild_controller
from robot.run.rig import Reading, Rig, Wires
from sim_hw.clock import VirtualClock
from sim_hw.host.recorded_wire import (
    Diverged,
    RecordedDatagrams,
    RecordedPort,
    RecordedText,
    Tape,
)

UNKNOWN_LATENCY_MS = 8.0


@dataclass(frozen=True, slots=True)
class WireDifference:
    """The first request that is not the recorded one.

    Attributes:
        t_s: Time since the first tick; negative while connecting.
        wire: Which wire.
        recorded: What was sent then, in words.
        recorded_hex: Its bytes; empty if nothing was.
        sent: What is sent now, in words.
        sent_hex: Its bytes; empty if nothing is.
        differs: In what they differ, in words.
    """

    t_s: float
    wire: str
    recorded: str
    recorded_hex: str
    sent: str
    sent_hex: str
    differs: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BusReplay(ComparedRun):
    """The result of a replay of bytes.

    Attributes:
        requests: Pieces that the drivers sent as recorded.
        bytes_sent: Their bytes.
        bytes_received: Bytes played to the drivers.
        wire: The first request that is another, None if there is none.
    """

    requests: int
    bytes_sent: int
    bytes_received: int
    wire: WireDifference | None

    @property
    def equal(self) -> bool:
        """Whether the drivers sent and understood the same."""
        return self.first is None and self.wire is None


class _Replayed:
    """A rig on a tape, whose time stamps and truth are those of the log: they are not in the bytes."""

    def __init__(self, rig: Rig, recorded: Tick) -> None:
        self._rig = rig
        self._recorded = recorded

    def read(self) -> Reading:
        reading, inputs = self._rig.read(), self._recorded.inputs
        servos = reading.servos
        if inputs.servos is not None:
            servos = replace(servos, t_ns=inputs.servos.t_ns, age_ns=inputs.servos.age_ns)
        return replace(
            reading, servos=servos, truth=inputs.truth, poses=inputs.poses, imu=inputs.imu
        )

    def actuate(self, allowed: Allowed) -> tuple[Fault, ...]:
        return self._rig.actuate(allowed)


def replay_bus(
    path: Path,
    *,
    scale: float = 1.0,
    config: RobotConfig | None = None,
    contents: LogContents | None = None,
    gait: str | None = None,
) -> BusReplay:
    """Replay the bytes of a log.

    Args:
        path: The log, recorded with ``bigant drive --record-bytes``.
        scale: Factor on all tolerances of the ticks; requests have none.
        config: Another robot file to try instead of the log's.
        contents: Filled on the way: robot file, metadata, damage, how far it is.
        gait: What may be run of a gait that a Python file gave: see ``with_gaits_of_log``.

    Raises:
        RecordError: The log cannot be read, holds no bytes or no ticks, or its devices do not answer.
    """
    pieces = read_wires(path, LogContents())
    contents = contents if contents is not None else LogContents()
    ticks = read_ticks(path, contents)
    first = next(ticks, None)
    if first is None:
        raise RecordError(f"{path} holds no ticks")
    began = time.perf_counter()
    rebuilt = rebuild_controller(contents, config, gait)
    tape = Tape(pieces, VirtualClock(pieces[0].t_ns))
    names = rebuilt.controller.config.parameters.legs.names
    comparison = Comparison((*WIRE_FIELDS, *FIELDS), names, scale, first.t_ns)
    notes = [*rebuilt.run.notes]
    wire: WireDifference | None = None
    end_ns, at_the_end = first.t_ns, False
    try:
        rig = _open(tape, rebuilt, contents)
        for recorded in _run(rig, tape, rebuilt.controller, chain((first,), ticks), comparison):
            end_ns = recorded.t_ns
        at_the_end = True
        rig.cut_torque()
        wire = _left_over(tape, first.t_ns)
    except Diverged as diverged:
        if diverged.recorded is None and at_the_end:
            notes.append("the recording ends before torque went off")
        else:
            wire = _wire_difference(diverged.recorded, diverged.sent, first.t_ns)
    except (BusError, ForceStreamError) as error:
        raise RecordError(
            f"the recorded bytes of {path} cannot be replayed with this version's drivers: {error}"
        ) from error
    if tape.skipped:
        notes.append(f"{len(tape.skipped)} recorded answers came too late for today's drivers")
    if contents.damage:
        notes.append(f"the file is {contents.damage}")
    played = tape.pieces[: tape.place]
    return BusReplay(
        path=path,
        ticks=comparison.ticks,
        requests=sum(piece.sent for piece in played),
        bytes_sent=sum(len(piece.data) for piece in played if piece.sent),
        bytes_received=sum(len(piece.data) for piece in played if not piece.sent),
        duration_s=(end_ns - first.t_ns) * 1e-9,
        wall_s=time.perf_counter() - began,
        fields=comparison.results(),
        first=comparison.first,
        wire=wire,
        notes=tuple(notes),
    )


def _run(
    rig: Rig, tape: Tape, controller: Controller, ticks: Iterable[Tick], comparison: Comparison
) -> Iterator[Tick]:
    """Do the loop's ticks again; yield the recorded tick of each that is done."""
    state = controller.initial()
    pending: tuple[Fault, ...] = ()
    for recorded in ticks:
        tape.clock.sleep_until_ns(recorded.t_ns)
        inputs = recorded.inputs
        # not from these devices
        others = (FaultKind.LOG_WRITE, FaultKind.POSE_BAD, FaultKind.IMU_BAD, FaultKind.IMU_STALE)
        of_others = tuple(f for f in inputs.faults if f.kind in others)
        wanted = replace(inputs, faults=(*pending, *of_others))
        devices = _Replayed(rig, recorded)
        state, tick, pending = exchange(devices, controller, state, wanted, recorded.t_ns)
        comparison.add(recorded, tick)
        yield recorded


def _open(tape: Tape, rebuilt: Rebuilt, contents: LogContents) -> Rig:
    config, metadata = rebuilt.controller.config, contents.metadata

    def links() -> tuple[DatagramLink, TextLink]:
        datagrams = RecordedDatagrams(tape)
        if metadata.get("time") == "real":  # in memory there is no old session to free
            free_console(datagrams, tape.clock)
        return datagrams, RecordedText(tape)

    latency_ms = float(metadata.get(LATENCY_KEY, UNKNOWN_LATENCY_MS))
    with_forces = metadata.get(FORCE_UNIT_KEY, "true") == "true"
    port = RecordedPort(tape, config.servo_bus.baud_rate, latency_ms)
    wires = Wires(tape.clock, port, config.force_sensor, links if with_forces else None)
    return assemble(config, wires, armed=rebuilt.controller.armed)


def _left_over(tape: Tape, start_ns: int) -> WireDifference | None:
    """Return the first request that was recorded and is not sent any more."""
    left = next((piece for piece in tape.pieces[tape.place :] if piece.sent), None)
    return None if left is None else _wire_difference(left, None, start_ns)


def _wire_difference(
    recorded: WireBytes | None, sent: WireBytes | None, start_ns: int
) -> WireDifference:
    known = recorded if recorded is not None else sent
    assert known is not None  # one of them is there
    differs = ""
    if recorded is not None and sent is not None:
        differs = difference_words(recorded, sent)
    return WireDifference(
        t_s=(known.t_ns - start_ns) * 1e-9,
        wire=wire_name(known.wire),
        recorded=_line(recorded),
        recorded_hex="" if recorded is None else recorded.data.hex(" "),
        sent=_line(sent),
        sent_hex="" if sent is None else sent.data.hex(" "),
        differs=differs,
    )


def _line(piece: WireBytes | None) -> str:
    return "nothing" if piece is None else "; ".join(words.line for words in wire_words(piece))
