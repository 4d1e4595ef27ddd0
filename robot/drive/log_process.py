"""The estimator, the log and the view of a run in virtual time, in a process beside the one that walks.

No command depends on the estimate, and none on the log. So the loop can go on while another core estimates
the ticks that are over, writes them and shows them. The log is the same to the byte. In real time a core is
fast enough for all of it, and a thread writes (``record.log.background``).
"""

import multiprocessing
import signal
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing.connection import Connection
from typing import Protocol, TypeAlias

from gaits.gait import Gait
from model.errors import RecordError
from model.values.estimate import Estimate
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log.background import CLOSE_LIMIT_S
from record.log.tick_message import TickEncoder, decode_tick
from record.log.writer import UNENCODABLE, LogWriter
from robot.config.robot_file import RobotConfig
from robot.console.processes import cores
from robot.control.state_bytes import bytes_of_state, state_of_bytes
from robot.control.tick_estimator import TickEstimator
from robot.run.loop import Observer

# Ticks that go over together: few enough that the view is up to date, enough that sending costs nothing.
BLOCK_TICKS = 64
# A run that is shorter is over before a process pays for its start.
WORTH_S = 20.0
REPAIR = "the log is cut, bigant log repair keeps what is there"
ENDED = f"the process that writes the log has ended; {REPAIR}"


class RunView(Observer, Protocol):
    """The live view, which shows what is left when it is closed."""

    def close(self) -> None:
        """Show what is left."""


@dataclass(frozen=True, slots=True)
class SentState:
    """A state that goes over, without what the estimator remembers: see ``LogWriter.write_state``."""

    t_ns: int
    index: int
    data: bytes


# A tick goes over as its message, without an estimate.
Sent: TypeAlias = bytes | tuple[WireBytes, ...] | SentState


@dataclass(frozen=True, slots=True)
class BesideRun:
    """What the process beside needs: inherited, so nothing of it is sent.

    Attributes:
        config: Robot file.
        gaits: The controller's, by name.
        open_log: Opens the log.
        open_view: Opens the view.
    """

    config: RobotConfig
    gaits: Mapping[str, Gait]
    open_log: Callable[[], LogWriter]
    open_view: Callable[[], RunView]


def worth_a_process(config: RobotConfig, expected_s: float | None) -> bool:
    """Tell whether a run in virtual time is worth a second process.

    Args:
        config: Robot file.
        expected_s: How long the robot is going to walk, None if nobody knows.
    """
    can = cores() > 1 and "fork" in multiprocessing.get_all_start_methods()
    long = expected_s is None or expected_s >= WORTH_S
    return can and long and config.estimator.enabled


class LogProcess:
    """Passes ticks without an estimate to a process that adds it, writes the log and shows the view.

    Args:
        beside: What that process needs.

    Raises:
        RecordError: The log cannot be opened.
    """

    def __init__(self, beside: BesideRun) -> None:
        context = multiprocessing.get_context("fork")
        receiver, self._sender = context.Pipe(duplex=False)
        self._words, words = context.Pipe(duplex=False)
        self._encoder = TickEncoder()
        self._block: list[Sent] = []
        self._failure: RecordError | None = None
        self._ended = self._closed = False
        self._process = context.Process(
            target=_work, args=(beside, receiver, self._sender, words), name="log"
        )
        self._process.start()
        receiver.close()
        words.close()
        try:
            self._hear(self._words.poll(CLOSE_LIMIT_S))
        except BaseException:
            self._sender.close()  # Ctrl-C: it leaves, too
            raise
        if self._failure is not None:
            self.close()
            raise self._failure

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written, None while it can."""
        return self._failure

    def write(self, tick: Tick) -> None:
        """Hand over one tick; waits while the process beside is far behind."""
        try:
            self._put(self._encoder.encode(tick))
        except UNENCODABLE as error:
            self._fail(f"the log takes no tick any more: {error}; please report it")

    def write_wires(self, pieces: tuple[WireBytes, ...]) -> None:
        """Hand over raw bytes of the devices."""
        if pieces:
            self._put(pieces)

    def write_state(self, t_ns: int, index: int, encode: Callable[[], bytes]) -> None:
        """Hand over a state."""
        self._put(SentState(t_ns, index, encode()))

    def _put(self, item: Sent) -> None:
        self._block.append(item)
        if len(self._block) >= BLOCK_TICKS:
            self._send()

    def _send(self) -> None:
        """Let the process have what waits, and hear what it has to say."""
        block, self._block = self._block, []
        if not self._ended:  # what no log takes is still shown
            try:
                self._sender.send(block)
            except OSError:
                self._hear(self._words.poll(CLOSE_LIMIT_S))  # why it does not listen any more
                self._ended = True
                self._fail(ENDED)
        self._hear(self._words.poll())

    def _hear(self, spoke: bool) -> None:
        if not spoke or self._ended:
            return
        try:
            self._fail(self._words.recv())
        except EOFError:
            self._ended = True
            self._fail(ENDED)

    def _fail(self, words: str) -> None:
        if words and self._failure is None:
            self._failure = RecordError(words)

    def close(self) -> None:
        """Let the process write what is left and finish the file."""
        if self._closed:
            return
        self._send()
        self._sender.close()  # end of file
        self._hear(self._words.poll(CLOSE_LIMIT_S))
        self._closed = True
        self._process.join(CLOSE_LIMIT_S)
        if self._process.is_alive():
            self._fail(f"the disk takes nothing any more; {REPAIR}")
            self._process.kill()
        self._words.close()


def _work(beside: BesideRun, receiver: Connection, sender: Connection, words: Connection) -> None:
    """Do all that is beside: say first whether the log is open, then what goes wrong if anything does."""
    sender.close()  # our own copy would keep the pipe open
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the run ends as the loop says, and we with it
    try:
        writer = beside.open_log()
    except RecordError as error:
        words.send(str(error))
        return
    words.send("")
    view = beside.open_view()
    scribe, failure = _Scribe(beside, writer, view), ""
    try:
        with suppress(EOFError):  # the loop is over, or its process is gone
            while True:
                for item in receiver.recv():
                    scribe.take(item)
                if writer.error is not None and not failure:
                    failure = str(writer.error)
                    words.send(failure)
    except Exception as error:  # noqa: BLE001 - whatever it is, the run has to know and the log to end
        failure = f"the log {writer.path} is cut: {type(error).__name__}: {error}; please report it"
        receiver.close()
    finally:
        writer.close()
        view.close()
    with suppress(OSError):  # nobody may be there to hear it
        words.send(failure or str(writer.error or ""))


class _Scribe:
    """Adds the estimate to ticks, writes and shows them.

    Args:
        beside: Robot and gaits.
        writer: The log.
        view: The view.
    """

    def __init__(self, beside: BesideRun, writer: LogWriter, view: RunView) -> None:
        self._beside = beside
        self._writer = writer
        self._view = view
        self._estimator = TickEstimator(beside.config)
        self._estimate: Estimate | None = None

    def take(self, item: Sent) -> None:
        """Take what came over, in its order."""
        if isinstance(item, SentState):
            self._writer.write_state(item.t_ns, item.index, partial(self._whole, item.data))
        elif isinstance(item, tuple):
            self._writer.write_wires(item)
        else:
            bare = decode_tick(item)
            self._estimate = self._estimator.step(bare.sensed)
            tick = replace(bare, estimate=self._estimate)
            self._writer.write(tick)
            self._view.show(tick)

    def _whole(self, data: bytes) -> bytes:
        """A state with what the estimator remembers."""
        state = state_of_bytes(data, self._beside.gaits)
        estimates = replace(
            state.estimates, estimate=self._estimate, estimator=self._estimator.memory
        )
        return bytes_of_state(replace(state, estimates=estimates))
