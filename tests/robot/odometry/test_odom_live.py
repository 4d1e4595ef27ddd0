"""The estimator beside a run: it follows a log that grows, and says what the loop's own says."""

import json
import re
import socket
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.lines.poses import PoseListener
from drivers.lines.sources import LOOPBACK
from model.estimator.smoother import smooth
from model.values.faults import StopReason
from model.values.tick import Intent, Tick
from record.log.writer import LogWriter
from robot.cli.main import main
from robot.config.robot_file import load_robot
from robot.control.controller import Controller
from robot.odometry.track import Tracker, track_log
from robot.replay.ticks import replay_log
from robot.run.header import controller_metadata
from robot.run.loop import run
from robot.virtual.open import VirtualSettings, open_in_memory
from tests.robot.runs import Kept, Told, wish

UNIX_NS = 1_767_225_600_000_000_000


def called(*words: str) -> int:
    """Run the program; return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["odom", *words])
    return int(ended.value.code or 0)


class Sender:
    """Sends a pose now and then, as a camera beside the robot would."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._there = (LOOPBACK, port)

    def show(self, tick: Tick) -> None:
        if tick.index % 20 == 5:
            unix_s = (UNIX_NS + tick.t_ns - 1_000_000_000) * 1e-9
            self._socket.sendto(f"{unix_s:.6f} 2 1 0 0 0 0 1".encode(), self._there)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Tick]]:
    """Three seconds of the virtual robot with poses from a socket, and its log."""
    path = tmp_path_factory.mktemp("live") / "run.mcap"
    config = load_robot()
    rig = open_in_memory(config, VirtualSettings(seed=2))
    listener = PoseListener(0, rig.clock, UNIX_NS)
    rig.listen(listener)
    controller = Controller(config, rig.calibrations, armed=True)
    kept, sender = Kept(), Sender(listener.port)
    operator = Told(
        lambda t, _: wish(Intent.WALK) if t < 3 else wish(Intent.CUT, reason=StopReason.EMERGENCY)
    )
    run(rig, controller, operator, kept, sender)
    sender.close()
    rig.close()
    writer = LogWriter(
        path, names=config.parameters.legs.names, config_text=config.text,
        metadata=dict(controller_metadata(controller, rig.calibrations)),
        start_ns=kept.ticks[0].t_ns, start_unix_ns=UNIX_NS,
    )  # fmt: skip
    for tick in kept.ticks:
        writer.write(tick)
    writer.close()
    return path, kept.ticks


def test_poses_are_in_the_log_and_replay_to_the_same_bits(log: tuple[Path, list[Tick]]) -> None:
    path, ticks = log
    heard = [tick for tick in ticks if tick.inputs.poses]
    assert len(heard) > 10
    found = replay_log(path, scale=0.0)
    assert found.equal
    assert found.equal_bits == len(ticks)


def test_offline_too_recorded_poses_are_used(log: tuple[Path, list[Tick]]) -> None:
    """They were not once."""
    path, ticks = log
    run = track_log(path).track
    for said, tick in zip(run.estimates, ticks, strict=True):
        assert tick.estimate is not None
        np.testing.assert_array_equal(said.position_m, tick.estimate.position_m)
        np.testing.assert_array_equal(said.pose_covariance, tick.estimate.pose_covariance)


def test_a_late_pose_corrects_the_states_that_are_smoothed(log: tuple[Path, list[Tick]]) -> None:
    tracker = Tracker(load_robot(), keep_states=True)
    for tick in log[1]:
        late = tuple(replace(pose, t_ns=tick.t_ns - 20_000_000) for pose in tick.inputs.poses)
        inputs = replace(tick.inputs, poses=late)
        tracker.take(tick.t_ns, replace(tick, inputs=inputs).sensed)
    run = tracker.track()
    assert [state.t_ns for state in run.states] == [tick.t_ns for tick in log[1]]
    corrected = [(state.mean[:2] != run.pose[i, :2]).any() for i, state in enumerate(run.states)]
    assert sum(corrected) > 10
    assert not corrected[-1]
    np.testing.assert_array_equal(smooth(run.states)[0][-1], run.states[-1].mean)


def test_the_command_says_what_the_loop_said(
    log: tuple[Path, list[Tick]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, ticks = log
    out = tmp_path / "live.tum"
    assert called("--live", str(path), "--out", str(out), "--json") == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    own = {tick.t_ns: tick.estimate for tick in ticks}
    assert len(lines) >= 3
    for line in lines:
        said = own[line["t_ns"]]
        assert said is not None
        assert line["position_m"] == said.position_m.tolist()
        assert line["pose_covariance"] == said.pose_covariance.tolist()
    rows = np.loadtxt(out)
    assert rows.shape == (len(ticks), 8)
    assert out.read_text().startswith(f"{UNIX_NS // 10**9}.")
    last = ticks[-1].estimate
    assert last is not None
    np.testing.assert_allclose(rows[-1, 1:3], last.position_m, atol=1e-9)


def test_lines_for_a_person(
    log: tuple[Path, list[Tick]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert called("--live", str(log[0])) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert re.search(r"0\.00 s  x .* mm  yaw .* deg .* (ok|degraded)", first)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--live"], "start bigant drive first"),
        (["--live", "a.mcap", "--hardware", "virtual"], "give one of them"),
        (["--live", "no.mcap"], "cannot be read"),
        (["--live", "no.mcap", "--compare"], "whole log"),
        (["--live", "no.mcap", "--out", "x.png"], ".tum"),
        (["--duration", "3", "a.mcap"], "go with --live"),
        ([], "name a log"),
    ],
)
def test_what_makes_no_sense_is_one_line(
    words: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert called(*words) != 0
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said
