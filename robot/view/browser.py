"""``bigant view --browser``: the 3-D page of a log, fed over a local socket while the run goes on.

Frames and numbers go out as server-sent events, which every browser reads by itself; whoever connects
later gets the last minute first. Nothing can be sent back.
"""

import json
import queue
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np

from model.errors import ConfigError
from record.log.reader import LogContents, StampedTick
from record.log.recording import Recording, build_recording
from robot.console.screen_fit import ESCAPE
from robot.report.page import live_page
from robot.report.replay import LEAST_STEP_S, replay_frames
from robot.view.narrow import narrow_lines
from robot.view.screen import fault_lines

EVENT_S = 0.25  # of the run: pieces in which frames go out
KEPT_EVENTS = 240  # a minute of them, for whoever connects later
MOST_WAITING = 1000  # events that a slow browser may lag behind before it is let go
QUIET_S = 10.0  # after which a comment is sent, so that a browser that is gone is noticed
CLOSE_S = 2.0
NAME_OF_END = "event: end\n"
GOOD, NO_SUCH_PAGE = 200, 404  # of HTTP


class FrameFeed:
    """Turns ticks into events: frames for the picture, and the lines of the terminal view.

    Args:
        contents: Of the log; filled by its reader.
    """

    def __init__(self, contents: LogContents) -> None:
        self._contents = contents
        self._anchor: StampedTick | None = None
        self._first_ns = self._due_ns = self._sent_ns = 0
        self._kept: list[StampedTick] = []
        self._late_ns = self._missed = 0

    def event(self, stamped: StampedTick) -> str | None:
        """Take a tick; return the next event if it is due."""
        tick, now_ns = stamped.tick, stamped.unix_ns
        if self._anchor is None:
            self._first_ns = self._due_ns = self._sent_ns = now_ns
        if self._anchor is None or (_has_truth(stamped) and not _has_truth(self._anchor)):
            self._anchor = stamped  # paths are begun where the truth is first known
        self._late_ns = max(self._late_ns, tick.inputs.timing.lateness_ns)
        self._missed += tick.inputs.timing.missed
        if now_ns >= self._due_ns:
            self._due_ns = now_ns + round(LEAST_STEP_S * 1e9)
            self._kept.append(stamped)
        return self.rest() if now_ns - self._sent_ns >= EVENT_S * 1e9 else None

    def rest(self) -> str | None:
        """Return an event of what has not been sent; None if there is nothing."""
        if not self._kept or self._anchor is None:
            return None
        newest, ticks = self._kept[-1], [self._anchor, *self._kept]
        self._sent_ns, self._kept = newest.unix_ns, []
        frames = replay_frames(self._recording(ticks), np.arange(1, len(ticks)))
        names = self._contents.machine(newest.tick)
        seconds = (newest.unix_ns - self._first_ns) * 1e-9
        lines = narrow_lines(newest.tick, names, seconds, self._late_ns, self._missed)
        faults = [ESCAPE.sub("", line) for line in fault_lines(newest.tick, 40)]
        return json.dumps({"frames": frames, "lines": [*lines, "", *faults]}, allow_nan=False)

    def _recording(self, ticks: Sequence[StampedTick]) -> Recording:
        return build_recording(
            [one.tick for one in ticks],
            machine=self._contents.machine(ticks[0].tick),
            start_ns=self._contents.start_ns(ticks[0].tick.t_ns),
            times_s=[(one.unix_ns - self._first_ns) * 1e-9 for one in ticks],
            config_text=self._contents.config_text,
            metadata=self._contents.metadata,
            damage="",
        )


def _has_truth(stamped: StampedTick) -> bool:
    truth = stamped.tick.inputs.truth
    return truth is not None and bool(np.isfinite(truth.position_W[0]))


class EventHub:
    """Hands every event to every browser that is connected; none of them can hold up another."""

    def __init__(self) -> None:
        self._lock = threading.Condition()
        self._past: deque[str] = deque(maxlen=KEPT_EVENTS)
        self._clients: list[queue.Queue[str]] = []
        self.watched = threading.Event()

    def send(self, data: str, name: str = "") -> None:
        """Send an event to all, now and later."""
        text = f"{name}data: {data}\n\n"
        with self._lock:
            self._past.append(text)
            for client in list(self._clients):
                try:
                    client.put_nowait(text)
                except queue.Full:
                    self._clients.remove(client)

    @contextmanager
    def client(self) -> Iterator["queue.Queue[str]"]:
        """Yield the queue of a browser, with the last minute in it."""
        own: queue.Queue[str] = queue.Queue(MOST_WAITING)
        with self._lock:
            for text in self._past:
                own.put_nowait(text)
            self._clients.append(own)
        self.watched.set()
        try:
            yield own
        finally:
            with self._lock:
                if own in self._clients:
                    self._clients.remove(own)
                self._lock.notify_all()

    def wait_for_all(self, seconds: float) -> None:
        """Wait until every browser has taken what it was sent and gone, but no longer than this."""
        with self._lock:
            self._lock.wait_for(lambda: not self._clients, seconds)


class _Handler(BaseHTTPRequestHandler):
    """Answers two addresses: the page, and its events."""

    def __init__(self, hub: EventHub, page: bytes, *words: object) -> None:
        self._hub, self._page = hub, page
        super().__init__(*words)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        """Answer a browser."""
        with suppress(OSError):  # it went away
            if self.path == "/":
                self._head("text/html; charset=utf-8", len(self._page))
                self.wfile.write(self._page)
            elif self.path == "/events":
                self._head("text/event-stream; charset=utf-8")
                self._events()
            else:
                self.send_error(NO_SUCH_PAGE)

    def _head(self, kind: str, length: int | None = None) -> None:
        self.send_response(GOOD)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.end_headers()

    def _events(self) -> None:
        with self._hub.client() as waiting:
            ended = False
            while not ended:
                try:
                    text = waiting.get(timeout=QUIET_S)
                except queue.Empty:
                    text = ": still here\n\n"
                self.wfile.write(text.encode())
                self.wfile.flush()
                ended = text.startswith(NAME_OF_END)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Say nothing on the terminal."""


class BrowserView:
    """A page and its events, served until it is closed.

    Args:
        title: Heading of the page.
        contents: Of the log.
        host: Address to listen at.
        port: Port; 0 for any.

    Attributes:
        hub: Where events go out.

    Raises:
        ConfigError: The address cannot be listened at.
    """

    def __init__(self, title: str, contents: LogContents, host: str, port: int) -> None:
        self._feed = FrameFeed(contents)
        self.hub = EventHub()
        page = live_page(title).encode("utf-8")
        try:
            self._server = ThreadingHTTPServer((host, port), partial(_Handler, self.hub, page))
        except OSError as error:
            raise ConfigError(
                "--port",
                f"{host}:{port} cannot be used ({error.strerror or error}); choose another, or 0",
            ) from error
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """What to open in a browser."""
        host, port = self._server.server_address[:2]
        return f"http://{host!s}:{port}/"

    def show(self, stamped: StampedTick) -> None:
        """Take a tick."""
        if (event := self._feed.event(stamped)) is not None:
            self.hub.send(event)

    def close(self) -> None:
        """Send what is left and that the run has ended, and stop."""
        if (event := self._feed.rest()) is not None:
            self.hub.send(event)
        self.hub.send("{}", NAME_OF_END)
        self.hub.wait_for_all(CLOSE_S)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(CLOSE_S)
