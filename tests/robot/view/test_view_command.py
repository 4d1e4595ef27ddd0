"""``bigant view``: what a viewer is sent, read back by somebody else's reader; live from a growing log."""

import base64
import json
import os
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from model.kinematics.legs import leg_kinematics
from model.values.estimate import Health
from model.values.faults import Fault, FaultKind
from model.values.machine_names import one_joint_a_leg
from model.values.parameters import CrankParameters, FourBarParameters
from model.values.tick import Mode
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.report.scene import METRES_PER_NEWTON, legs_of, turn_from_x
from robot.view import log_source
from robot.view import watch as view_command
from robot.view.frames import FrameTracker
from robot.view.numbers import NewsTracker, known, numbers_of
from tests.record.ticks import NAMES, make_tick

ROOT = Path(__file__).resolve().parents[3]
PARAMETERS = load_robot().parameters


def test_feet_are_drawn_where_the_linkage_puts_them_and_forces_begin_there() -> None:
    tick = make_tick(3)
    angles = np.linspace(-1, 2, 6)
    forces = np.arange(18.0).reshape(6, 3) + 1
    tick = replace(
        tick,
        joints=replace(tick.joints, angle_rad=angles),
        forces=replace(tick.forces, force_n=forces),
    )
    assert isinstance(PARAMETERS.leg, FourBarParameters)
    kinematics = leg_kinematics(PARAMETERS)
    feet = kinematics.feet(angles, np.zeros(6)).position_m
    for leg, scene in enumerate(legs_of(tick, PARAMETERS)):
        np.testing.assert_allclose(scene.feet[0].place, feet[leg], atol=1e-12)
        np.testing.assert_allclose(scene.forces[0].start, feet[leg], atol=1e-12)
        np.testing.assert_allclose(scene.forces[0].vector, METRES_PER_NEWTON * forces[leg])
        crank = scene.links[0].points
        np.testing.assert_allclose(
            np.linalg.norm(crank[1] - crank[0]), PARAMETERS.leg.crank, rtol=1e-9
        )


@pytest.mark.parametrize("radius", [0.0, 0.03, 0.045])
def test_a_crank_is_drawn_from_its_shaft_to_its_toe_and_its_foot_is_lowest(radius: float) -> None:
    leg = CrankParameters(0.09, radius)
    angles = np.linspace(-1.2, 1.2, 6)
    tick = make_tick(3)
    tick = replace(tick, joints=replace(tick.joints, angle_rad=angles))
    shafts = PARAMETERS.legs.shaft_position
    for at, scene in enumerate(legs_of(tick, replace(PARAMETERS, leg=leg))):
        points = np.concatenate([strip.points for strip in scene.links])
        np.testing.assert_allclose(points[0], shafts[at], atol=1e-12)
        toe = shafts[at] - leg.length * np.array([np.sin(angles[at]), 0.0, np.cos(angles[at])])
        np.testing.assert_allclose(points[-1], toe, atol=1e-12)
        # the half circle is drawn with corners: its lowest one is at most a chord's height off
        assert points[:, 2].min() == pytest.approx(scene.feet[0].place[2], abs=0.005 * 0.045)


def test_a_silent_servo_has_no_leg_and_an_unknown_force_no_arrow() -> None:
    tick = make_tick(3)
    angles = np.array([np.nan, 0, 0, 0, 0, 0.0])
    force = np.full((6, 3), np.nan)
    tick = replace(
        tick,
        joints=replace(tick.joints, angle_rad=angles),
        forces=replace(tick.forces, force_n=force),
        contact=replace(
            tick.contact, traction=replace(tick.contact.traction, force_B=np.zeros((6, 3)))
        ),
    )
    legs = legs_of(tick, PARAMETERS)
    assert not legs[0].links
    assert not legs[0].feet
    assert len(legs[1].links) == 3
    assert all(leg.forces == () for leg in legs)


@pytest.mark.parametrize("vector", [(1, 0, 0), (-2, 0, 0), (0, 0, 3), (1, -2, 0.5), (-1, 1e-3, 0)])
def test_arrows_point_along_their_force(vector: tuple[float, float, float]) -> None:
    direction = np.array(vector, dtype=float) / np.linalg.norm(vector)
    turned = Rotation.from_quat(turn_from_x(np.array(vector, dtype=float))).apply([1.0, 0, 0])
    np.testing.assert_allclose(turned, direction, atol=1e-9)


def test_odom_begins_where_the_truth_is() -> None:
    """At the first tick base_link by way of odom, and the truth, are one place and heading."""
    tick = make_tick(0)
    assert tick.inputs.truth is not None
    truth = replace(
        tick.inputs.truth,
        position_W=np.array([2.0, 3.0, 0.1]),
        quaternion_xyzw=Rotation.from_euler("z", 1.2).as_quat(),
    )
    estimate = replace(tick.dead_reckoning, position_m=np.array([0.4, -0.2]), yaw_rad=0.3)
    tick = replace(tick, inputs=replace(tick.inputs, truth=truth), dead_reckoning=estimate)
    odom, body, true = FrameTracker().transforms(tick)
    turn = Rotation.from_quat(odom.rotation_xyzw)
    place = odom.translation + turn.apply(body.translation)
    np.testing.assert_allclose(place[:2], true.translation[:2], atol=1e-12)
    heading = (turn * Rotation.from_quat(body.rotation_xyzw)).as_euler("zyx")[0]
    np.testing.assert_allclose(heading, 1.2)
    assert [t.parent for t in (odom, body, true)] == ["map", "odom", "map"]


def test_numbers_leave_out_what_is_not_known_and_nothing_else() -> None:
    fields: dict[str, list[str]] = {}
    for index in range(20):
        tick = make_tick(index)
        messages = dict(numbers_of(tick, one_joint_a_leg(NAMES)))
        found = {topic: known(numbers) for topic, numbers in messages.items()}
        for leg, name in enumerate(NAMES):
            measured = np.isfinite(tick.joints.angle_rad[leg])
            assert ("angle_rad" in found[f"/servo/{name}"]) == measured
            force = found[f"/force/{name}"]
            if "measured.z_n" in force and "predicted.z_n" in force:
                error = float(force["predicted.z_n"]) - float(force["measured.z_n"])
                assert force["difference.z_n"] == pytest.approx(error)
        for topic, numbers in messages.items():
            assert fields.setdefault(topic, list(numbers)) == list(numbers), "a schema is made once"


def test_a_fault_is_news_when_it_comes_and_when_it_comes_again() -> None:
    fault = Fault(FaultKind.SERVO_SILENT, "HL", "no answer")
    quiet = replace(make_tick(0), faults=(), mode=Mode.WALK)
    loud = replace(quiet, faults=(fault,))
    tracker = NewsTracker()
    told = [
        sum(news.fault for news in tracker.news_of(t)) for t in (quiet, loud, loud, quiet, loud)
    ]
    assert told == [0, 1, 0, 0, 1]


def test_the_saved_file_opens_in_another_reader_with_everything_in_it(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("foxglove")
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    saved, layout = tmp_path / "view.mcap", tmp_path / "layout.json"
    code = cli.run(["view", str(short_walk), "--save", str(saved), "--layout", str(layout)])
    assert code == ExitCode.OK
    assert "pictures of" in capsys.readouterr().out
    with saved.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = list(reader.iter_messages())
        scenes = [m for *_, m in reader.iter_decoded_messages(topics=["/robot"])]
        frames = [m for *_, m in reader.iter_decoded_messages(topics=["/tf"])]
        paths = [m for *_, m in reader.iter_decoded_messages(topics=["/trajectory"])]
    topics = {channel.topic for _, channel, _ in messages}
    wanted = {"/robot", "/trajectory", "/tf", "/velocity", "/estimate", "/state", "/log"}
    assert topics >= wanted | {f"/force/{name}" for name in NAMES}
    ids = {entity.id for entity in scenes[-1].entities}
    assert ids == {"body in base_link", "body in base_link_true"} | {f"leg {n}" for n in NAMES}
    legs = [entity for entity in scenes[-1].entities if entity.id.startswith("leg")]
    assert all(len(leg.lines) == 3 and len(leg.spheres) == 1 for leg in legs)
    assert sum(len(leg.arrows) for leg in legs) >= 6, "at rest on six feet"
    assert {t.child_frame_id for t in frames[-1].transforms} == {
        "odom", "base_link", "base_link_true",
    }  # fmt: skip
    assert {entity.id for entity in paths[-1].entities} == {"true", "dead reckoning", "estimator"}
    states = [json.loads(m.data) for _, c, m in messages if c.topic == "/state"]
    assert {"START", "WALK"} <= {state["mode"] for state in states}
    loads = [json.loads(m.data) for _, c, m in messages if c.topic == "/force/HL"]
    assert any("measured" in load and "predicted" in load for load in loads)
    velocities = [json.loads(m.data) for _, c, m in messages if c.topic == "/velocity"]
    assert any({"true", "predicted", "estimated"} <= set(one) for one in velocities)
    said = [json.loads(m.data) for _, c, m in messages if c.topic == "/estimate"]
    assert {one["health"] for one in said} <= {health.value for health in Health}
    assert said[-1]["x_sd_m"] > 0
    panels = layout.read_text(encoding="utf-8")
    assert json.loads(panels)["content"]["type"] == "split"
    for topic in ("/robot", "/velocity.true.vx_m_s", "/force/HL.measured.z_n", "/state.mode"):
        assert topic in panels, topic


def test_a_file_for_rerun_is_whole_and_holds_the_robot_and_its_numbers(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Read back by Rerun's own program; a picture of its viewer is docs/figures/viewer.png."""
    pytest.importorskip("rerun", reason="rerun-sdk (640 MB) is not installed")
    saved = tmp_path / "view.rrd"
    assert cli.run(["view", str(short_walk), "--save", str(saved)]) == ExitCode.OK
    assert f"open it with: rerun {saved}" in capsys.readouterr().out

    def rrd(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "rerun_cli", "rrd", *words, str(saved)],
            capture_output=True, text=True, check=True, env={**os.environ, "RERUN_ANALYTICS": "0"},
        )  # fmt: skip
        return done.stdout + done.stderr

    rrd("verify")
    held = rrd("print")
    body = "/map/odom/base_link"
    for path in (
        f"{body}/links", f"{body}/feet", f"{body}/forces/measured", f"{body}/forces/predicted",
        "/map/base_link_true", "/map/way/true", "/news", "/plots/velocity/vx_m_s/estimated",
        "/plots/force/HL/z_n/difference", "/plots/estimate/x_sd_m", "/plots/servo/HL/current_a",
    ):  # fmt: skip
        assert f" {path} " in held, path


def test_a_file_for_rerun_without_its_package_or_with_foxglove_s_layout_is_refused(
    short_walk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(view_command, "RERUN_PACKAGE", "no_such_package_of_anybody")
    assert cli.run(["view", str(short_walk), "--save", "a.rrd"]) == ExitCode.USAGE
    assert "[rerun]" in capsys.readouterr().err
    words = ["view", str(short_walk), "--save", "a.rrd", "--layout", "a.json"]
    assert cli.run(words) == ExitCode.USAGE
    assert "its own layout" in capsys.readouterr().err


def test_a_change_of_health_is_news() -> None:
    tick = next(t for t in map(make_tick, range(20)) if t.estimate is not None)
    assert tick.estimate is not None
    good = replace(tick, estimate=replace(tick.estimate, health=Health.OK, reason=""))
    lost = replace(tick, estimate=replace(tick.estimate, health=Health.LOST, reason="why"))
    tracker = NewsTracker()
    tracker.news_of(good)
    told = [[news.text for news in tracker.news_of(t)] for t in (good, lost, lost, good)]
    assert told == [[], ["lost: why"], [], ["ok"]]


class _WritingClock:
    """A clock whose waiting is what lets the writer go on: a live run in virtual time."""

    def __init__(self, data: bytes, path: Path) -> None:
        self._ns = 0
        self._left = data
        self._path = path

    def now_ns(self) -> int:
        return self._ns

    def sleep_until_ns(self, t_ns: int) -> None:
        self._ns = max(self._ns, t_ns)
        with self._path.open("ab") as writer:
            writer.write(self._left[:60_000])
        self._left = self._left[60_000:]


def test_live_in_a_terminal_follows_the_log_to_its_end(
    short_walk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    data = short_walk.read_bytes()
    growing = tmp_path / "runs" / "now.mcap"
    growing.parent.mkdir()
    growing.write_bytes(data[:50_000])
    clock = _WritingClock(data[50_000:], growing)
    monkeypatch.setattr("robot.view.watch.MonotonicClock", lambda: clock)
    monkeypatch.setattr(view_command, "be_nice", lambda: None)
    monkeypatch.chdir(tmp_path)
    assert cli.run(["view", "--live", "--terminal"]) == ExitCode.OK
    captured = capsys.readouterr()
    assert f"following {Path('runs') / 'now.mcap'}" in captured.err
    assert "WALK" in captured.out
    assert "COMPLETED" in captured.out, "to the last tick"


def test_a_log_that_stops_growing_is_told_once(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from record.log.follow import LogFollower

    cut = tmp_path / "cut.mcap"
    data = short_walk.read_bytes()
    cut.write_bytes(data[: len(data) // 2])

    class PatienceError(Exception):
        pass

    class Waiting(_WritingClock):
        def sleep_until_ns(self, t_ns: int) -> None:
            super().sleep_until_ns(t_ns)
            if t_ns > 20 * 10**9:
                raise PatienceError

    with LogFollower(cut) as follower, pytest.raises(PatienceError):
        list(log_source.followed(follower, Waiting(b"", cut)))
    assert capsys.readouterr().err.count("has not grown for 5 s") == 1


def test_a_recorded_log_is_played_at_its_speed(short_walk: Path) -> None:
    from record.log.reader import read_stamped_ticks

    clock = _WritingClock(b"", Path(os.devnull))
    stamped = read_stamped_ticks(short_walk)
    played = list(log_source.paced(stamped, lambda t: t.unix_ns, clock, 2.0))
    took_ns = (played[-1].unix_ns - played[0].unix_ns) / 2
    assert clock.now_ns() == pytest.approx(took_ns, rel=1e-9)


class Viewer:
    """A viewer's side of the websocket (RFC 6455), down to the bytes."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        key = base64.b64encode(bytes(16)).decode()
        self._socket.sendall(
            f"GET / HTTP/1.1\r\nHost: localhost:{port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n".encode()
        )
        answer = b""
        while not answer.endswith(b"\r\n\r\n"):
            answer += self._socket.recv(1)
        assert answer.startswith(b"HTTP/1.1 101")
        self._stream = self._socket.makefile("rb")

    def frames(self) -> Iterator[tuple[int, bytes]]:
        """Opcode and payload of what comes, until the other side closes."""
        while len(head := self._stream.read(2)) == 2:
            size = head[1] & 0x7F
            if size == 126:
                (size,) = struct.unpack(">H", self._stream.read(2))
            elif size == 127:
                (size,) = struct.unpack(">Q", self._stream.read(8))
            opcode = head[0] & 0x0F
            if opcode == 8:  # close
                return
            yield opcode, self._stream.read(size)

    def subscribe(self, channel: int) -> None:
        """Ask for a channel; a client masks what it sends, here with zeros."""
        wish = {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channel}]}
        text = json.dumps(wish).encode()
        assert len(text) < 126
        self._socket.sendall(bytes((0x81, 0x80 | len(text), 0, 0, 0, 0)) + text)

    def close(self) -> None:
        self._stream.close()
        self._socket.close()


def test_a_viewer_on_the_network_is_told_all_topics() -> None:
    pytest.importorskip("foxglove")
    from robot.view.foxglove import FoxgloveView

    view = FoxgloveView(PARAMETERS, None, ("127.0.0.1", 0))
    try:
        assert not view.watched
        view.show(make_tick(3), 10**9)
        viewer = Viewer(view.port)
        topics: set[str] = set()
        for _, payload in viewer.frames():
            message = json.loads(payload)
            if message["op"] == "serverInfo":
                assert message["name"] == "bigant"
            topics |= {channel["topic"] for channel in message.get("channels", ())}
            if {"/velocity", "/robot", "/tf", "/force/FR", "/servo/HL", "/state"} <= topics:
                break
        viewer.close()
    finally:
        view.close()


def test_a_log_waits_for_its_viewer_and_is_then_played_to_the_end(short_walk: Path) -> None:
    pytest.importorskip("foxglove")
    process = subprocess.Popen(
        [sys.executable, "-m", "bigant", "view", str(short_walk), "--port", "0", "--speed", "50"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        viewer = Viewer(int(line.split()[1].rpartition(":")[2]))
        scenes = 0
        for opcode, payload in viewer.frames():
            if opcode == 1:
                for channel in json.loads(payload).get("channels", ()):
                    if channel["topic"] == "/robot":
                        assert channel["schemaName"] == "foxglove.SceneUpdate"
                        viewer.subscribe(channel["id"])
            elif payload[0] == 1:  # message data
                scenes += 1
        viewer.close()
        _, complaints = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == ExitCode.OK, complaints
    assert scenes > 50


def test_the_newest_log_is_no_file_of_a_viewer(
    short_walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    first, begun = Path("runs/first.mcap"), Path("runs/begun.mcap")
    first.write_bytes(short_walk.read_bytes())
    for number, library in enumerate(("foxglove-sdk-rust", "bigant odom", "", "x" * 300)):
        path = Path(f"runs/first-view{number}.mcap")
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start(profile="ros2", library=library)
            writer.finish()  # type: ignore[no-untyped-call]
        os.utime(path, (2e9, 2e9 + number))
    Path("runs/text.mcap").write_text("no log at all")
    assert log_source.newest_log() == first
    begun.write_bytes(b"")  # a drive has opened its log and written nothing yet
    os.utime(begun, (3e9, 3e9))
    assert log_source.newest_log() == begun


def test_wrong_use_is_one_clear_line(
    short_walk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    for words, wanted in (
        (["view"], "name a log"),
        (["view", "--live"], "start bigant drive first"),
        (["view", "absent.mcap", "--terminal"], "cannot be read"),
        (["view", str(short_walk), "--headless"], "add --save"),
        (["view", str(short_walk), "--save", "x.bag"], "must end in .mcap or .rrd"),
        (["view", str(short_walk), "--terminal", "--save", "x.mcap"], "leave out"),
    ):
        assert cli.run(words) in {ExitCode.USAGE, ExitCode.LOG}
        printed = capsys.readouterr().err
        assert wanted in printed
        assert len(printed.splitlines()) == 1


def test_without_the_package_the_extra_is_named(
    short_walk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(view_command, "PACKAGE", "no_such_package_of_anybody")
    assert cli.run(["view", str(short_walk)]) == ExitCode.USAGE
    printed = capsys.readouterr().err
    assert "[view]" in printed
    assert "docs/view.md" in printed


def test_watching_does_not_write_to_the_log(short_walk: Path, tmp_path: Path) -> None:
    before = short_walk.read_bytes()
    short_walk.chmod(0o444)
    assert cli.run(["view", str(short_walk), "--terminal", "--speed", "1000"]) == ExitCode.OK
    assert short_walk.read_bytes() == before
