"""Walks of a twin: with and without bytes the same, the same for the same seed; campaigns and seals."""

import json
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from model.errors import ConfigError, ModelError, RecordError
from record.log.reader import LogContents, read_ticks
from record.trial.trial import Trial, read_trial
from robot.campaign.plan import draw_cases, read_scenario
from robot.campaign.run import Job, campaign_jobs, drop_cases, run_jobs
from robot.campaign.seal import labels_of, make_key, read_key, seal, unseal
from robot.cli.main import run as command
from robot.config.robot_file import load_robot, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.twin_run import WalkPlan, make_twin, plan_of, walk_fast, walk_through_bytes
from sim_hw.faults.scenario import parse_scenario
from sim_hw.host.world import World
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import parse_effect
from tests.robot.scenarios import FEW, SCENARIO, write_scenario

CONFIG = load_robot()
FIELDS = (
    "time_s", "command_rad", "shaft_rad", "shaft_rad_s", "current_a", "voltage_v", "temperature_c",
    "foot_m", "force_n", "body_position_m", "body_angles_rad",
    "imu",
)  # fmt: skip


@pytest.mark.soak
def test_without_bytes_the_same_trial_comes_out() -> None:
    """Also with what sits in servos, force unit, IMU and cameras: counts are equal, not just near.

    A reply in which three bytes happen to look like a header takes one byte, 10 us, more on the wire: that
    much the times of a few camera frames differ, nothing else.
    """
    config = parse_robot(CONFIG.text + '\n[imu]\nport = "/dev/ttyIMU"\n')
    words = ("command_delay:delay_s=0.03", "force_lowpass:time_constant_s=0.05",
             "pose_delay:delay_s=0.04", "foot_friction@ML:ratio=0.5")  # fmt: skip
    twin = make_twin(config, tuple(parse_effect(word, EFFECTS) for word in words), seed=4)
    plan = WalkPlan("metachronal", 0.2, 1.2, steer=0.3)
    shares: list[float] = []
    fast = walk_fast(config, twin, plan, shares.append)
    whole = walk_through_bytes(config, twin, plan, None, lambda _: None)
    for field in FIELDS:
        near = 2e-6 if field in {"foot_m", "body_position_m", "body_angles_rad"} else 1e-9
        assert np.abs(getattr(fast, field) - getattr(whole, field)).max() < near, field
    assert len(fast.time_s) == 120
    assert shares == sorted(shares)
    assert np.isfinite(fast.force_n).all()
    assert np.isfinite(fast.imu).all()


@pytest.mark.soak
def test_a_twins_log_can_be_replayed(tmp_path: Path) -> None:
    """Step by step through today's controller, the calibrations taken from the log."""
    out = tmp_path / "twin.mcap"
    words = ["sim", "run", "--seconds", "0.2", "--seed", "2", "--out", str(out)]
    assert command([*words, "--effect", "com_offset:x_m=0.02"]) == 0
    assert command(["replay", str(out)]) == 0
    contents = LogContents()
    assert sum(1 for _ in read_ticks(out, contents)) > 20
    assert "com_offset" not in str(contents.metadata), "no word of what is wrong"


def test_faults_of_a_scenario_come_on_top_of_a_twin() -> None:
    """One path opens both: the force unit's faults lie on the wire, the twin's errors before it."""
    twin = make_twin(CONFIG, (parse_effect("force_gain@ML:ratio=2", EFFECTS),), seed=0)
    scenario = parse_scenario(
        """
        [[fault]]
        kind = "stuck_shaft"
        servo = 2
        torque_n_m = 30.0
        [[fault]]
        kind = "overheating"
        servo = 3
        temperature_c = 70.0
        """,
        (1, 2, 3, 4, 5, 6),
    )
    rig, robot = open_twin(CONFIG, twin, VirtualSettings(armed=False, scenario=scenario))
    try:
        seen = rig.read().servos
        assert isinstance(robot.world, World)
        assert robot.world.plant.jam_n_m.tolist() == [0.0, 30.0, 0.0, 0.0, 0.0, 0.0]
        assert seen.temperature_c.tolist() == [25, 25, 70, 25, 25, 25]
        assert robot.cameras is not None
    finally:
        rig.close()


def test_the_same_seed_gives_the_same_bytes_and_another_day_is_another(tmp_path: Path) -> None:
    files = []
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        out = tmp_path / f"{name}.parquet"
        words = ["sim", "run", "--fast", "--seconds", "0.2", "--seed", str(seed), "--out", str(out)]
        assert command([*words, "--effect", "gusts:sd_n=2"]) == 0
        files.append(out.read_bytes())
    assert files[0] == files[1]
    assert files[0] != files[2]
    trial = read_trial(tmp_path / "a.parquet")
    assert trial.header.noise.body_position_m > 0
    assert trial.header.notes == "", "no word of what is wrong"


def test_a_robot_that_would_stop_is_an_error_not_a_shorter_trial() -> None:
    twin = make_twin(CONFIG, (parse_effect("servo_speed_limit:limit_rad_s=0.2", EFFECTS),), seed=0)
    with pytest.raises(ModelError, match="would have stopped"):
        walk_fast(CONFIG, twin, plan_of(CONFIG, "tripod", 0.2, 5.0, 0.0), lambda _: None)


@pytest.mark.parametrize(
    ("walk", "limit"),
    [
        (walk_fast, "max_distance = 0.03"),
        (partial(walk_through_bytes, log=None), "max_tilt = 0.001\ntilt_time = 0.02"),
        pytest.param(walk_fast, "max_tilt = 0.001\ntilt_time = 0.02", marks=pytest.mark.soak),
        pytest.param(
            partial(walk_through_bytes, log=None), "max_distance = 0.03", marks=pytest.mark.soak
        ),
    ],
)
def test_limits_on_the_body_stop_either_walk(walk: Callable[..., Trial], limit: str) -> None:
    config = parse_robot(f"{DEFAULT_ROBOT_FILE.read_text()}\n[safety]\n{limit}\n")
    twin = make_twin(config, (), seed=0)
    with pytest.raises(ModelError, match="would have stopped"):
        walk(config, twin, plan_of(config, "tripod", 0.2, 5.0, 0.0), progress=lambda _: None)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--out", "x.mcap", "--fast"], 2),
        (["--out", "x.txt"], 2),
        (["--out", "nowhere/x.parquet"], 2),
        (["--out", "x.parquet", "--effect", "drag@ML"], 2),
        (["--out", "x.parquet", "--frequency-hz", "9"], 2),
    ],
)
def test_wrong_words_give_one_line(
    words: list[str], code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["sim", "run", *words]) == code
    assert capsys.readouterr().err.count("\n") == 1


def test_effects_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["sim", "effects"]) == 0
    assert "ground_slope" in capsys.readouterr().out
    assert command(["sim", "effects", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert len(listed) == len(EFFECTS)
    assert listed[0]["parameters"][0]["unit"] == "s"


class Here(Executor):
    """An executor that works here and now, and counts."""

    def __init__(self) -> None:
        self.count = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.count += 1
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@pytest.fixture
def scenario_file(tmp_path: Path) -> Path:
    return write_scenario(tmp_path, SCENARIO)


def test_cases_are_drawn_from_the_entropy_alone(scenario_file: Path) -> None:
    scenario = read_scenario(scenario_file)
    cases = draw_cases(scenario, b"one")
    assert cases == draw_cases(scenario, b"one")
    assert {c.name for c in cases}.isdisjoint({c.name for c in draw_cases(scenario, b"two")})
    kinds = [case.kind for case in cases]
    assert kinds.count("single") == 2 * 40
    assert (kinds.count("control"), kinds.count("pair"), kinds.count("outside")) == (1, 6, 6)
    assert [c.name for c in cases] == sorted(c.name for c in cases), "order says nothing"
    for case in cases:
        make_twin(CONFIG, case.effects, 0)  # every one can be made
        if case.kind == "pair":
            stages = {next(k.stage for k in EFFECTS if k.name == e.name) for e in case.effects}
            assert len(stages) == 2


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that was interrupted once, and what was counted on the way."""
    folder = tmp_path_factory.mktemp("campaign")
    scenario = read_scenario(write_scenario(folder, FEW))
    jobs = campaign_jobs(scenario, b"x", folder / "out")
    assert len(jobs) == 4
    first = Here()
    assert run_jobs(jobs[:2], first, lambda _: None) == ()
    kept = jobs[0].out.read_bytes()
    second = Here()
    told: list[int] = []
    assert run_jobs(jobs, second, told.append) == ()
    assert (first.count, second.count) == (2, 2), "goes on where it stood"
    assert told == [3, 4]
    assert jobs[0].out.read_bytes() == kept
    return folder


def test_a_campaign_goes_on_where_it_stood(campaign: Path) -> None:
    jobs = campaign_jobs(read_scenario(campaign / "scenario.toml"), b"x", campaign / "out")
    again = Here()
    assert run_jobs(jobs, again, lambda _: None) == ()
    assert again.count == 0
    assert not list(campaign.rglob("*.part"))


def test_files_of_a_campaign_say_nothing(campaign: Path) -> None:
    jobs = campaign_jobs(read_scenario(campaign / "scenario.toml"), b"x", campaign / "out")
    tables = [job.out for job in jobs]
    sizes = {path.stat().st_size for path in tables}
    assert len(sizes) == 1, "one size, whatever is wrong"
    assert len({path.stat().st_mtime_ns for path in tables}) == 1
    assert len({path.with_suffix(".toml").read_bytes() for path in tables}) == 1
    assert len({str(pq.read_schema(path).remove_metadata()) for path in tables}) == 1, "columns"
    kept = [pq.read_metadata(path).metadata for path in tables]
    assert all(set(one) == {b"padding"} and not one[b"padding"].strip(b".") for one in kept)
    names = [kind.name for kind in EFFECTS]
    for path in (campaign / "out").rglob("*"):
        assert not any(name in path.name for name in names)
        if path.is_file():
            assert not any(name.encode() in path.read_bytes() for name in names)


def test_a_seal_opens_with_its_key_alone(scenario_file: Path, tmp_path: Path) -> None:
    labels = labels_of(draw_cases(read_scenario(scenario_file), b"z"), b"z")
    folder = tmp_path / "sealed"
    folder.mkdir()
    key = make_key(tmp_path / "key")
    digest = seal(labels, folder, key)
    assert digest in (folder / "labels.sha256").read_text()
    assert b"friction" not in (folder / "labels.sealed").read_bytes()
    assert unseal(folder, read_key(tmp_path / "key")) == labels
    with pytest.raises(RecordError, match="does not open"):
        unseal(folder, make_key(tmp_path / "another"))
    (tmp_path / "bad").write_text("no key")
    with pytest.raises(ConfigError, match="holds no key"):
        read_key(tmp_path / "bad")
    token = bytearray((folder / "labels.sealed").read_bytes())
    token[50] ^= 1
    (folder / "labels.sealed").write_bytes(bytes(token))
    with pytest.raises(RecordError, match="not the file"):
        unseal(folder, key)
    for damaged in (b"", b"abc  labels.sealed\n", b"\xff\xfe\x00"):
        (folder / "labels.sha256").write_bytes(damaged)
        with pytest.raises(RecordError, match="is damaged"):
            unseal(folder, key)


def test_a_case_that_cannot_be_walked_is_left_out_whole(tmp_path: Path) -> None:
    stop = (parse_effect("servo_speed_limit:limit_rad_s=0.1", EFFECTS),)
    plan = WalkPlan("tripod", 0.2, 5.0, 0.0)
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "trial_1.parquet").write_bytes(b"made before")
    bad = Job(DEFAULT_ROBOT_FILE, stop, plan, 0, folder / "trial_2.parquet")
    failures = run_jobs([bad], Here(), lambda _: None)
    assert len(failures) == 1
    assert "would have stopped" in failures[0].reason
    assert drop_cases(failures) == 1
    assert not folder.exists()


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('"tripod"', '"hop"', "no gait"),
        ('["*"]', '["frction"]', "not known"),
        ('["*"]', '["tilt_coupling"]', "cannot be switched"),
        ("[[0.0, 0.3], [0.7, 1.0]]", "[1.0]", "ranges"),
        ("pairs = 6", "pears = 6", "pairs"),
    ],
)
def test_scenarios_that_make_no_sense(
    scenario_file: Path, before: str, after: str, words: str
) -> None:
    scenario_file.write_text(SCENARIO.replace(before, after))
    with pytest.raises(ConfigError, match=words):
        read_scenario(scenario_file)
