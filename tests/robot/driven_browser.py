"""A headless Chromium that is clicked, dragged and asked, over its DevTools pipe: no library is needed.

The browser reads commands from its file descriptor 3 and writes answers and events to 4: JSON, each ended
by a zero byte. See https://chromedevtools.github.io/devtools-protocol/.
"""

import base64
import fcntl
import json
import os
import select
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from tests.robot.browser import QUIET, find_browser

LONGEST_S = 60.0
KEYS = {"ArrowRight": 39, "ArrowLeft": 37, " ": 32}


class Tab:
    """The one tab of a browser.

    Attributes:
        errors: What the page's console would show as an error or a warning, and exceptions, since it was
            opened.
    """

    def __init__(self, write: int, read: int) -> None:
        self.errors: list[str] = []
        self._write, self._read = write, read
        self._rest, self._number, self._session = b"", 0, ""
        self._happened: list[dict[str, Any]] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method: str, **values: object) -> dict[str, Any]:
        """Send a command and return its answer; what happens meanwhile is kept."""
        self._number += 1
        number = self._number
        told: dict[str, object] = {"id": number, "method": method, "params": values}
        if self._session:
            told["sessionId"] = self._session
        os.write(self._write, json.dumps(told).encode() + b"\0")
        while True:
            one = self._next()
            if one.get("id") == number:
                assert "error" not in one, (method, one["error"])
                answer: dict[str, Any] = one["result"]
                return answer
            self._note(one)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._read], [], [], LONGEST_S)
            assert ready, "the browser does not answer"
            self._rest += os.read(self._read, 1 << 20)
        line, self._rest = self._rest.split(b"\0", 1)
        one: dict[str, Any] = json.loads(line)
        return one

    def _note(self, one: dict[str, Any]) -> None:
        self._happened.append(one)
        values = one.get("params", {})
        match one.get("method"):
            case "Runtime.exceptionThrown":
                self.errors.append(json.dumps(values["exceptionDetails"])[:400])
            case "Runtime.consoleAPICalled" if values["type"] in {"error", "warning"}:
                self.errors.append(json.dumps(values["args"])[:400])
            case "Log.entryAdded" if values["entry"]["level"] in {"error", "warning"}:
                self.errors.append(json.dumps(values["entry"])[:400])

    def show(self, width_px: int, height_px: int = 800, *, dark: bool = False, paper: bool = False,
             touch: bool = False) -> Self:  # fmt: skip
        """Set the size of the screen, its colours, and whether it is paper."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width_px, height=height_px,
                 deviceScaleFactor=1, mobile=touch)  # fmt: skip
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.ask("Emulation.setEmulatedMedia", media="print" if paper else "", features=[scheme])
        return self

    def open(self, page: Path, *, scripts: bool = True) -> Self:
        """Open a file and wait until it is loaded."""
        self.ask("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.errors.clear()
        self._happened.clear()
        self.ask("Page.navigate", url=page.resolve().as_uri())
        while not any(one.get("method") == "Page.loadEventFired" for one in self._happened):
            self._note(self._next())
        return self

    def run(self, script: str) -> Any:
        """Return the value of an expression in the page; of a promise, what it comes to."""
        told = self.ask(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in told, told["exceptionDetails"]
        return told["result"].get("value")

    def until(self, script: str) -> Any:
        """Wait until an expression is true, and return it."""
        return self.run(
            "(async () => { for (let i = 0; i < 2000; i++) { const value = (" + script + ");"
            "if (value) return value; await new Promise(done => setTimeout(done, 10)); }"
            f"throw new Error('never: ' + {json.dumps(script)}); }})()"
        )

    def place(self, element: str) -> tuple[float, float, float, float]:
        """Bring an element (a script that returns it) into view; return its left, top, width, height."""
        self.run(f"({element}).scrollIntoView({{block: 'center'}})")
        box = self.run(
            f"(b => [b.left, b.top, b.width, b.height])(({element}).getBoundingClientRect())"
        )
        left, top, width, height = box
        return left, top, width, height

    def click(self, element: str) -> None:
        """Click into the middle of an element."""
        left, top, width, height = self.place(element)
        self.press((left + width / 2, top + height / 2))

    def press(self, *places: tuple[float, float]) -> None:
        """Press the mouse at the first place, drag it along the others, and let go at the last."""
        self._mouse("mouseMoved", places[0], 0)
        self._mouse("mousePressed", places[0], 1)
        for one in places[1:]:
            self._mouse("mouseMoved", one, 1)
        self._mouse("mouseReleased", places[-1], 0)

    def hover(self, place: tuple[float, float]) -> None:
        """Move the mouse."""
        self._mouse("mouseMoved", place, 0)

    def _mouse(self, kind: str, place: tuple[float, float], buttons: int) -> None:
        x, y = place
        button = "none" if kind == "mouseMoved" and not buttons else "left"
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=buttons,
                 clickCount=1)  # fmt: skip

    def key(self, name: str) -> None:
        """Press a key."""
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=name, code=name,
                     windowsVirtualKeyCode=KEYS[name])  # fmt: skip

    def picture(self, out: Path, *, whole: bool = False) -> Path:
        """Write what is seen, or the whole page, to a PNG."""
        told = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        out.write_bytes(base64.b64decode(told["data"]))
        return out


@contextmanager
def driven_browser(folder: Path) -> Iterator[Tab]:
    """A browser with a profile of its own in a folder, and one tab; it ends with the block."""
    to_read, to_write = os.pipe()
    back_read, back_write = os.pipe()

    def pipes() -> None:
        # to high numbers first: one of the pipes may be 3 or 4 itself
        ours, theirs = (
            fcntl.fcntl(one, fcntl.F_DUPFD_CLOEXEC, 20) for one in (to_read, back_write)
        )
        os.dup2(ours, 3)
        os.dup2(theirs, 4)

    words = [
        find_browser(),
        *QUIET,
        f"--user-data-dir={folder / 'driven'}",
        "--remote-debugging-pipe",
    ]
    browser = subprocess.Popen(
        words, preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )  # fmt: skip
    os.close(to_read)
    os.close(back_write)
    try:
        yield Tab(to_write, back_read)
    finally:
        os.close(to_write)  # the browser ends when nobody can ask it
        try:
            browser.wait(timeout=20)
        except subprocess.TimeoutExpired:
            browser.kill()
            browser.wait()
        os.close(back_read)
