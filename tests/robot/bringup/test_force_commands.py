"""bigant force: on a virtual unit over loopback, right and wrong."""

import csv
import io
import json
import os
import select
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.clock import ClockEstimate
from drivers.ati.stream import StreamCounters
from drivers.clock import MonotonicClock
from model.errors import ModelError
from model.fit.force_bias import BLOCKS, measure_bias, require_rest
from model.values.arrays import FloatArray
from model.values.readings import ForceRecord
from robot.bringup.force.bias import standing_warnings
from robot.bringup.force.table import Snapshot, bridge_low, led, leg_lines, stream_lines
from robot.bringup.force.watch import show
from robot.cli import main as cli
from robot.config.calibration import read_calibration
from robot.console.exit_codes import ExitCode
from robot.console.screen_fit import ESCAPE, Screen
from sim_hw.ati.sockets import WnetSockets
from sim_hw.ati.unit import VirtualWnet

LEGS = ("HL", "ML", "FL", "HR", "MR", "FR")


class Offsets:
    """Leg k reads k + 1 tenths in every axis; with ``touch`` someone leans on it now and then."""

    def __init__(self) -> None:
        self.touch = False
        self.terminate_at = -1
        self._calls = 0

    def wrench(self, t_ns: int) -> FloatArray:
        self._calls += 1
        if self._calls == self.terminate_at:
            signal.raise_signal(signal.SIGTERM)
        leaning = 3.0 * self.touch * (self._calls % 100 > 50)
        return np.tile(np.arange(0.1, 0.65, 0.1)[:, None], (1, 6)) + leaning


class Served:
    """A virtual unit on loopback, in a thread."""

    def __init__(self) -> None:
        self.source = Offsets()
        self.unit = VirtualWnet(self.source, (1, 2, 3, 4, 5, 6), seed=1)
        self.sockets = WnetSockets(self.unit)
        self.address = f"127.0.0.1:{self.sockets.udp_port}:{self.sockets.console_port}"
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        clock = MonotonicClock()
        while not self._done.is_set():
            select.select(self.sockets.filenos(), [], [], 0.002)
            self.sockets.service(clock.now_ns())

    def wait_for_stop(self) -> None:
        """The stop is on its way to the thread that serves; without one this fails."""
        clock = MonotonicClock()
        for _ in range(500):
            if not self.unit.streaming:
                return
            clock.sleep_until_ns(clock.now_ns() + 10_000_000)
        raise AssertionError("the unit was not told to stop")

    def close(self) -> None:
        self._done.set()
        self._thread.join()
        self.sockets.close()


@pytest.fixture
def served() -> Iterator[Served]:
    made = Served()
    yield made
    made.close()


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    """No program holds the console, so nothing has to be waited for."""
    monkeypatch.setattr("drivers.ati.setup.RESET_PAUSE_S", 0.005)


def bigant(*words: object) -> int:
    return cli.run([str(w) for w in words])


def test_scan_finds_the_unit(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    where = f"127.0.0.1:{served.sockets.discovery_port}"
    assert bigant("devices", "--port", "none", "--discover", where) == ExitCode.OK
    assert "Wireless F/T (virtual)" in capsys.readouterr().out
    assert bigant("devices", "--port", "none", "--discover", where, "--json") == ExitCode.OK
    assert json.loads(capsys.readouterr().out)["force_units"][0]["address"] == "127.0.0.1"
    assert bigant("devices", "--port", "none", "--discover", "none") == ExitCode.VERDICT_FAILED


@pytest.mark.soak
def test_watch_shows_and_writes_and_stops_the_unit(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "w.csv"
    words = ["force", "watch", "--force-unit", served.address, "--seconds", "1.2", "--csv", path]
    assert bigant(*words) == ExitCode.OK
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "LED green" in out
    assert "battery byte 0x07" in out
    assert "clock  host (monotonic) minus unit" in out
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["leg"] for row in rows} == set(LEGS)
    assert bigant(*words[:-2], "--json") == ExitCode.OK
    told = json.loads(capsys.readouterr().out)
    assert told["counters"]["records"] > 0
    last = {leg["leg"]: leg["force_n"][0] for leg in told["legs"]}
    assert last["FR"] == pytest.approx(0.6, abs=0.3)
    heavy = [float(row["fx_n"]) for row in rows if row["leg"] == "FR"]
    assert np.mean(heavy) == pytest.approx(0.6, abs=0.05)
    served.wait_for_stop()


@pytest.mark.soak
def test_bias_is_measured_and_written(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "b.toml"
    words = ["force", "bias", "--force-unit", served.address, "--seconds", "1.5", "--out", path]
    assert bigant(*words) == ExitCode.OK
    found = read_calibration(path, LEGS)
    truth = np.tile(np.arange(0.1, 0.65, 0.1)[:, None], (1, 6))
    error = np.abs(found.unloaded[..., 0] - truth)
    assert (error < 6 * found.standard_error + 1e-6).all()
    assert (found.standard_error[:, :3] < 0.02).all()
    assert found.method == "bias"
    assert found.serials[0] == "VIRTUAL1"
    assert "+-" in capsys.readouterr().out
    assert bigant(*words, "--json") == ExitCode.OK
    told = json.loads(capsys.readouterr().out)
    again = read_calibration(path, LEGS)
    assert told["axes"][0] == "Fx"
    assert [leg["leg"] for leg in told["legs"]] == list(LEGS)
    np.testing.assert_allclose([leg["bias"] for leg in told["legs"]], again.unloaded[..., 0])
    assert all(state.bias is None for state in served.unit.state), "the unit's own is left alone"


def test_a_touched_robot_is_refused(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    served.source.touch = True
    path = tmp_path / "b.toml"
    words = ["force", "bias", "--force-unit", served.address, "--seconds", "1", "--out", path]
    assert bigant(*words) == ExitCode.USAGE
    error = capsys.readouterr().err
    assert "the robot was touched" in error
    assert error.count("\n") == 1
    assert not path.exists()
    served.wait_for_stop()


@pytest.mark.parametrize(("command", "code"), [("watch", ExitCode.OK), ("bias", ExitCode.USAGE)])
def test_the_unit_is_stopped_when_the_program_is_told_to_end(
    served: Served, tmp_path: Path, command: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    served.source.terminate_at = 60
    more = ["--out", tmp_path / "b.toml"] if command == "bias" else []
    words = ["force", command, "--force-unit", served.address, "--seconds", "60", *more]
    assert bigant(*words) == code
    served.wait_for_stop()
    assert not (tmp_path / "b.toml").exists()
    assert ("interrupted" in capsys.readouterr().err) is (command == "bias")


def test_the_units_own_bias_only_on_demand(served: Served, tmp_path: Path) -> None:
    words = ["force", "bias", "--force-unit", served.address, "--seconds", "1", "--device"]
    assert bigant(*words, "--out", tmp_path / "b.toml") == ExitCode.OK
    assert all(state.bias is not None for state in served.unit.state)
    found = read_calibration(tmp_path / "b.toml", LEGS)
    assert np.abs(found.unloaded[:, :3, 0]).max() < 0.2, "counted from zero now"


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["devices", "--port", "none", "--discover", "here:70000"], 2, "--discover"),
        (["force", "watch", "--force-unit", "a:b:c"], 2, "--force-unit: must be HOST"),
        (["force", "watch", "--calibration", "none.toml"], 2, "cannot be read"),
        (["force", "calibrate"], 2, "name one or more logs"),
        (["force", "calibrate", "none.mcap"], 4, "none.mcap cannot be read"),
        (["force", "calibrate", "x.mcap", "--report", "r.pdf"], 2, "must end in .png"),
    ],
)
def test_wrong_input_is_one_clear_line(
    words: list[str], code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant(*words) == code
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


# The pure parts.


def test_the_bias_and_its_error_are_those_of_the_samples() -> None:
    random = np.random.default_rng(0)
    sensed = 2.0 + 0.02 * random.standard_normal((1000, 2, 6))
    sensed[:, 1] = np.nan
    bias = measure_bias(sensed)
    require_rest(bias, ("A", "B"))
    assert bias.known.tolist() == [True, False]
    assert bias.mean[0] == pytest.approx(2.0, abs=4 * 0.02 / np.sqrt(1000))
    assert bias.standard_error[0] == pytest.approx(
        0.02 / np.sqrt(1000), rel=4 / np.sqrt(2 * BLOCKS)
    )


def test_a_robot_that_stands_is_suspected() -> None:
    mean = np.zeros((6, 6))
    mean[:, 2] = 10.5
    mean[5] = np.nan  # one transducer is silent
    (said,) = standing_warnings(mean, 6.5)
    assert "52 N along z, and the robot weighs 64 N: does it stand?" in said
    assert standing_warnings(mean / 4, 6.5) == ()


def test_a_slow_drift_is_refused_though_its_spread_is_small() -> None:
    sensed = np.zeros((1000, 1, 6))
    sensed[:, 0, 2] = np.linspace(0, 0.4, 1000)
    with pytest.raises(ModelError, match=r"A: Fz wanders by 0\.36 N \(limit 0\.2\)"):
        require_rest(measure_bias(sensed), ("A",))
    with pytest.raises(ModelError, match="no sensor gave 50 sound samples"):
        require_rest(measure_bias(sensed[:20]), ("A",))


def test_status_words_of_a_real_unit_are_decoded() -> None:
    """TAMS-Group's dump: T1 to T3 green; T4 red and saturated, T5 green."""
    status = np.array([0x00150AAA, 0x01050009])
    assert [led(status, n) for n in range(1, 7)] == [
        "green",
        "green",
        "green",
        "red",
        "green",
        "off",
    ]
    assert not any(bridge_low(status, n) for n in range(1, 7))
    assert bridge_low(np.array([0, 1 << 28]), 5)


def bad_shot() -> Snapshot:
    """One transducer red and saturated, one not in the packets."""
    status = np.array([0x00150AAA, 0x01050009])
    present = np.array([1, 1, 1, 1, 1, 0], dtype=bool)
    saturated = np.array([0, 0, 0, 1, 0, 0], dtype=bool)
    counts = np.zeros((6, 6), dtype=np.int64)
    return Snapshot(
        seconds=1.0,
        names=LEGS,
        transducers=np.array([1, 2, 3, 4, 5, 6]),
        record=ForceRecord(0, 0, 0, status, 7, 0x1F, counts, present, saturated),
        wrench=np.where(np.arange(6)[:, None] == 3, np.nan, np.full((6, 6), -1.5)),
        age_ns=np.array([0, 0, 0, -1, 0, -1]),
        rate_hz=100.0,
        counters=StreamCounters(records=5, missing=2),
        clock=ClockEstimate(3_000_000_000, float("nan"), 1e6, 5, 0, 0),
        repair_error="",
    )


def test_the_table_names_what_is_wrong() -> None:
    shot = bad_shot()
    lines = [*leg_lines(shot), *stream_lines(shot)]
    assert lines[1].split()[:5] == ["HL", "1", "-1.50", "-1.50", "-1.50"]
    assert lines[4].endswith("LED red, SATURATED")
    assert lines[4].split()[2:9] == ["-"] * 7
    assert lines[6].endswith("not in the packets")
    assert "lost 2" in lines[7]
    assert "WLAN green   power green   battery green   battery byte 0x07" in lines[8]
    assert "minus unit 3.0000 s   drift not known yet" in lines[9]


class Terminal(io.StringIO):
    """A terminal of 80 by 24 letters."""

    def fileno(self) -> int:
        raise OSError


def test_the_screen_of_watch_fits_its_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    size = os.terminal_size((80, 24))
    monkeypatch.setattr("robot.console.screen_fit.terminal_size", lambda _: size)
    terminal = Terminal()
    show(bad_shot(), Screen(terminal))
    lines = [ESCAPE.sub("", line) for line in terminal.getvalue().split("\r\n")]
    assert max(map(len, lines)) <= 80
    assert lines[5].endswith("LED red, SATURATED"), "nothing of it is cut off"
    text = " ".join(" ".join(lines).split())
    for words in (
        "lost 2",
        "set up again 0",
        "(no unit known)",
        "drift not known yet",
        "rollovers 0",
    ):
        assert words in text
    assert lines[-1] == "Ctrl-C ends"
