"""Draw what Rerun's own web viewer shows of a walk: docs/figures/viewer.png.

Needs bigant[rerun] and a Chromium; without them it says so and leaves the picture as it is. The browser
draws in software and is spoken to over a pipe (Chrome DevTools Protocol), so no display and no package
for browsers is needed: ``python docs/draw_viewer.py [LOG]``.
"""

import base64
import importlib.util
import itertools
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from drivers.clock import MonotonicClock

OUT = Path(__file__).resolve().parent / "figures" / "viewer.png"
WALK = Path("runs/docs/first_walk.mcap")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZE = (1400, 900)
WAIT_S = 90.0  # drawn in software; a busy computer takes its time
FLAGS = (
    "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--hide-scrollbars",
    "--remote-debugging-pipe",
)  # fmt: skip

# The browser reads descriptor 3 and writes 4, whatever numbers our pipes have.
PIPES = (
    "import os, sys; from fcntl import F_DUPFD, fcntl; "
    "high = [fcntl(int(one), F_DUPFD, 10) for one in sys.argv[1:3]]; "
    "[os.dup2(one, at) for at, one in enumerate(high, 3)]; "
    "os.execvp(sys.argv[3], sys.argv[3:])"
)


class Browser:
    """A Chromium that is told what to do through two pipes: JSON, each message ended by a zero byte."""

    def __init__(self, program: str, profile: Path) -> None:
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()
        window = f"--window-size={SIZE[0]},{SIZE[1]}"
        words = [program, *FLAGS, window, f"--user-data-dir={profile}"]
        self._process = subprocess.Popen(
            [sys.executable, "-c", PIPES, str(theirs_in), str(theirs_out), *words],
            pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._read, self._write = os.fdopen(ours_in, "rb"), os.fdopen(ours_out, "wb")
        self._numbers = itertools.count(1)

    def ask(self, method: str, session: str = "", **parameters: Any) -> dict[str, Any]:
        """Send a command and return its answer; events in between are not for us."""
        number = next(self._numbers)
        message: dict[str, Any] = {"id": number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        self._write.write(json.dumps(message).encode() + b"\0")
        self._write.flush()
        while True:
            answer = json.loads(self._message())
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                result: dict[str, Any] = answer["result"]
                return result

    def _message(self) -> bytes:
        text = bytearray()
        while (one := self._read.read(1)) not in {b"", b"\0"}:
            text += one
        if not text:
            raise RuntimeError("the browser went away")
        return bytes(text)

    def picture(self, address: str, wait_s: float) -> bytes:
        """Open an address, let it draw, and return what is on the screen as PNG."""
        clock, session = self._page(), self._page()
        self.ask("Page.bringToFront", session)  # a page behind another does not draw
        light = [{"name": "prefers-color-scheme", "value": "light"}]
        self.ask("Emulation.setEmulatedMedia", session, features=light)
        width, height = SIZE
        self.ask("Emulation.setDeviceMetricsOverride", session, width=width, height=height,
                 deviceScaleFactor=1, mobile=False)  # fmt: skip
        self.ask("Page.navigate", session, url=address)
        waiting = f"new Promise(done => setTimeout(done, {wait_s * 1e3:.0f}))"
        # a page that waits beside it: one that navigates forgets what it was asked
        self.ask("Runtime.evaluate", clock, expression=waiting, awaitPromise=True)
        shot = self.ask("Page.captureScreenshot", session, format="png")
        return base64.b64decode(shot["data"])

    def _page(self) -> str:
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        answer = self.ask("Target.attachToTarget", targetId=target, flatten=True)
        return str(answer["sessionId"])

    def close(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait(20)


def free_port() -> int:
    """Return a port that nobody listens at now."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def wait_for(port: int, seconds: int = 60) -> None:
    """Return when something listens at a port."""
    clock = MonotonicClock()
    for _ in range(10 * seconds):
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) == 0:
                return
        clock.sleep_until_ns(clock.now_ns() + 100_000_000)
    raise RuntimeError(f"nothing listens at port {port} after {seconds} s")


def draw(recording: Path, out: Path, wait_s: float = WAIT_S) -> None:
    """Serve a recording to the web viewer and keep a picture of it."""
    program = next(path for name in BROWSERS if (path := shutil.which(name)))
    web, grpc = free_port(), free_port()
    server = subprocess.Popen(
        [sys.executable, "-m", "rerun_cli", "--serve-web", "--bind", "127.0.0.1", "--web-viewer-port",
         str(web), "--port", str(grpc), str(recording)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env={**os.environ, "RERUN_ANALYTICS": "0"}, start_new_session=True,
    )  # fmt: skip
    source = f"rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{grpc}%2Fproxy"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, Path(profile))
        try:
            wait_for(web)
            address = f"http://127.0.0.1:{web}/?url={source}&renderer=webgl&hide_welcome_screen"
            out.write_bytes(browser.picture(address, wait_s))
        finally:
            browser.close()
            os.killpg(server.pid, signal.SIGTERM)  # it has a child that does the work
            server.wait(20)


def main() -> None:
    """Save a log for the viewer and draw it."""
    if importlib.util.find_spec("rerun") is None or not any(map(shutil.which, BROWSERS)):
        print(f"{OUT.name} left as it is: needs bigant[rerun] and a Chromium")
        return
    from robot.cli import main as cli

    log = Path(sys.argv[1]) if sys.argv[1:] else WALK
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "walk.rrd"
        if code := cli.run(["view", str(log), "--save", str(recording)]):
            sys.exit(code)
        draw(recording, OUT)
    print(OUT.name)


if __name__ == "__main__":
    main()
