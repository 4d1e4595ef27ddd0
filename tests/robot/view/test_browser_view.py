"""``bigant view --browser``: what goes out over the socket, and what a browser makes of it."""

import base64
import json
import re
import socket
import threading
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.errors import ConfigError
from record.log.reader import LogContents, StampedTick, read_stamped_ticks
from robot.cli import main as cli
from robot.view.browser import MOST_WAITING, BrowserView, EventHub, FrameFeed
from tests.robot.browser import find_browser, run_browser


@pytest.fixture(scope="module")
def read(cycle_walk: Path) -> tuple[list[StampedTick], LogContents]:
    contents = LogContents()
    return list(read_stamped_ticks(cycle_walk, contents)), contents


def events_of(ticks: list[StampedTick], contents: LogContents) -> list[dict[str, Any]]:
    feed = FrameFeed(contents)
    sent = [feed.event(one) for one in ticks]
    return [json.loads(one) for one in (*sent, feed.rest()) if one is not None]


def floats(text: str) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def test_events_together_are_the_walk_and_each_is_short(
    read: tuple[list[StampedTick], LogContents],
) -> None:
    ticks, contents = read
    events = events_of(ticks, contents)
    span_s = (ticks[-1].unix_ns - ticks[0].unix_ns) * 1e-9
    assert len(events) == pytest.approx(span_s / 0.25, rel=0.1)
    times = np.concatenate([floats(one["frames"]["t"]) for one in events])
    assert (np.diff(times) > 0.03).all(), "no frame twice, in order, 25 a second"
    assert times[-1] == pytest.approx(span_s, abs=0.05)
    places = np.concatenate([floats(one["frames"]["place"]) for one in events]).reshape(-1, 3)
    by_time = {round((one.unix_ns - ticks[0].unix_ns) * 1e-9, 2): one.tick for one in ticks}
    for at in (0, len(times) // 2, len(times) - 1):
        truth = by_time[round(float(times[at]), 2)].inputs.truth
        assert truth is not None
        np.testing.assert_allclose(places[at], truth.position_W, atol=1e-5)


def test_paths_of_all_events_begin_at_one_place(
    read: tuple[list[StampedTick], LogContents],
) -> None:
    """The drift of the estimator is seen: its path is not begun anew in every event."""
    ticks, contents = read
    paths = [one["frames"]["paths"] for one in events_of(ticks, contents)]
    last_true, last_own = (floats(paths[-1][name])[-2:] for name in ("true", "dead reckoning"))
    first_true, first_own = (floats(paths[0][name])[:2] for name in ("true", "dead reckoning"))
    np.testing.assert_allclose(first_own, first_true, atol=1e-3)
    drift = float(np.hypot(*(last_own - last_true)))
    assert drift > 1e-3


def test_lines_are_those_of_the_terminal(read: tuple[list[StampedTick], LogContents]) -> None:
    ticks, contents = read
    lines = events_of(ticks[:60], contents)[-1]["lines"]
    assert lines[-1] == "no faults"
    assert any(line.startswith("HL ") for line in lines)
    assert not any("\x1b" in line for line in lines)


def test_a_page_and_its_events_are_served_on_the_loopback_address_only(
    read: tuple[list[StampedTick], LogContents],
) -> None:
    ticks, contents = read
    view = BrowserView("runs/<walk>.mcap", contents, "127.0.0.1", 0)
    assert view.address.startswith("http://127.0.0.1:")
    page = urllib.request.urlopen(view.address, timeout=5).read().decode()
    assert "runs/&lt;walk&gt;.mcap" in page
    assert not re.search(r"(src|href)=.https?:", page)
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(view.address + "etc/passwd", timeout=5)
    for one in ticks[:200]:
        view.show(one)
    told: list[str] = []

    def listen() -> None:
        with urllib.request.urlopen(view.address + "events", timeout=5) as stream:
            told.extend(line.decode() for line in stream)

    late = threading.Thread(target=listen)
    late.start()
    assert view.hub.watched.wait(5)
    view.close()
    late.join(5)
    assert not late.is_alive(), "its stream ends with the run"
    events = [json.loads(line[6:]) for line in told if line.startswith("data: ")]
    assert len(events) >= 8, "who comes late gets what went before"
    assert "event: end\n" in told
    assert events[-1] == {}


def test_a_browser_that_takes_nothing_is_let_go_and_holds_up_nobody() -> None:
    hub = EventHub()
    with hub.client() as slow, hub.client() as quick:
        for number in range(MOST_WAITING + 5):
            hub.send(str(number))
            assert quick.get_nowait() == f"data: {number}\n\n"
        assert slow.qsize() == MOST_WAITING
        slow.get_nowait()
        hub.send("later")
        waiting = [slow.get_nowait() for _ in range(slow.qsize())]
        assert waiting[-1] == f"data: {MOST_WAITING - 1}\n\n", "it gets nothing more"


@pytest.mark.parametrize("other", [["--terminal"], ["--save", "a.mcap"], ["--ros2"]])
def test_a_browser_goes_with_nothing_else(
    other: list[str], short_walk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["view", str(short_walk), "--browser", *other]) == 2
    assert "leave out the other options" in capsys.readouterr().err


def test_a_port_that_is_taken_is_said(read: tuple[list[StampedTick], LogContents]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ConfigError, match=r"cannot be used .*choose another, or 0"):
            BrowserView("x", read[1], "127.0.0.1", taken.getsockname()[1])


@pytest.mark.skipif(not find_browser(), reason="needs a Chromium")
def test_a_browser_draws_what_comes(
    read: tuple[list[StampedTick], LogContents], tmp_path: Path
) -> None:
    ticks, contents = read
    view = BrowserView("a walk", contents, "127.0.0.1", 0)

    def play() -> None:
        view.hub.watched.wait(20)
        for one in ticks:
            view.show(one)
        view.close()

    player = threading.Thread(target=play)
    player.start()
    dom = run_browser(
        tmp_path, "--virtual-time-budget=6000", "--window-size=360,800", "--dump-dom", view.address
    )
    player.join(20)
    assert "the run has ended" in dom
    assert 'class="replay live"' in dom
    (clock,) = re.findall(r"<output>([\d.]+) s</output>", dom)
    span_s = (ticks[-1].unix_ns - ticks[0].unix_ns) * 1e-9
    assert 0.0 < float(clock) <= span_s + 0.01
    slider = re.findall(r'<input type="range"[^>]*max="([\d.]+)"', dom)
    assert float(slider[0]) == pytest.approx(span_s, abs=0.05)
    assert "no faults" in dom
