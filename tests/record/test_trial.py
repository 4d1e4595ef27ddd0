"""A trial: what is written is what is read, to the last bit; what is wrong is said."""

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from model.errors import RecordError
from record.trial.header import TrialHeader, TrialNoise
from record.trial.table_file import TableColumn, read_table
from record.trial.trial import Trial, build_trial, read_trial, trial_places, write_trial

LEGS = ("HL", "ML", "FL", "HR", "MR", "FR")
BENCH = 'kind = "servo_bench"\n[joint.arm]\n[joint.wrist]\nmotor = { supply_v = 7.4 }\n'
SLIDER = 'kind = "sliding_body"\n[body]\nmass = 0.37\n[contact]\nlaw = "viscous"\nmu = 0.2\n'
HEXAPOD = f"name = 'x'\r\n[legs]\norder = {list(LEGS)}\n"


def make_header(robot_text: str = "", **changes: object) -> TrialHeader:
    values: dict[str, object] = {
        "kind": "legged", "joints": LEGS, "gait": "tripod", "frequency_hz": 0.1,
        "sample_rate_hz": 100.0, "notes": "", "noise": TrialNoise(force_n=0.15),
        "robot_file": "machine.toml" if robot_text else "", "robot_text": robot_text,
    }  # fmt: skip
    return TrialHeader(**{**values, **changes})  # type: ignore[arg-type]


def make_trial(header: TrialHeader, count: int = 30, seed: int = 0) -> Trial:
    """Every column full of random numbers, a tenth of them missing."""
    rng = np.random.default_rng(seed)
    columns = [TableColumn("time_s", np.arange(count) / 100)]
    for place in trial_places(header.names):
        values = rng.normal(size=count)
        values[rng.random(count) < 0.1] = np.nan
        columns.append(TableColumn(place.column, values))
    return build_trial(header, tuple(columns))


def assert_same(one: Trial, other: Trial) -> None:
    """Bit for bit, but that one NaN is as good as another."""
    assert same_header(one.header) == same_header(other.header)
    for field in dataclasses.fields(Trial)[1:]:
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert a.shape == b.shape, field.name
        np.testing.assert_array_equal(a, b, err_msg=field.name)
        np.testing.assert_array_equal(np.signbit(a[a == 0]), np.signbit(b[a == 0]))


def same_header(header: TrialHeader) -> str:
    return repr(header)  # NaN is NaN there


machines = st.sampled_from([
    ("legged", "", ()), ("legged", HEXAPOD, LEGS), ("legged", "name = 'no legs'\n", ()),
    ("servo_bench", BENCH, ("arm", "wrist")), ("sliding_body", SLIDER, ()),
])  # fmt: skip
figures = st.floats(allow_nan=True, allow_infinity=True)


@st.composite
def trials(draw: st.DrawFn) -> Trial:
    kind, text, named = draw(machines)
    others = st.lists(
        st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,6}", fullmatch=True), unique=True, max_size=3
    )
    joints = named if draw(st.booleans()) else tuple(draw(others))
    conditions = st.dictionaries(
        st.from_regex(r"[a-z_]{1,8}", fullmatch=True),
        st.text(max_size=5) | st.floats(allow_nan=False),
        max_size=3,
    )
    header = TrialHeader(
        kind=kind, joints=joints, gait=draw(st.text(max_size=8)), frequency_hz=draw(figures),
        sample_rate_hz=draw(figures), notes=draw(st.text()),
        noise=TrialNoise(*(draw(figures) for _ in range(5))),
        robot_file="machine.toml" if text else "", robot_text=text,
        legs=tuple(draw(others)),  # apart from the joints
        conditions=tuple(draw(conditions).items()),
        constants=(("kp", tuple(map(float, range(len(joints))))),) if joints else (),
        drive=draw(st.sampled_from(["", 'kind = "pd"\nlimit = [1, 2.5]\n'])),
    )  # fmt: skip
    count = draw(st.integers(0, 6))
    times = draw(
        st.lists(st.floats(-1e12, 1e12), unique=True, min_size=count, max_size=count).map(sorted)
    )
    columns = [TableColumn("time_s", np.array(times, dtype=np.float64))]
    places = list(trial_places(header.names))
    chosen = draw(st.lists(st.sampled_from(places), unique=True, max_size=8))
    columns += [
        TableColumn(place.column, draw(npst.arrays(np.float64, count, elements=figures)))
        for place in chosen
    ]
    return build_trial(header, tuple(columns))


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(trial=trials())
def test_what_is_written_is_what_is_read(tmp_path: Path, suffix: str, trial: Trial) -> None:
    folder = tmp_path / "trial"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    write_trial(trial, folder / f"t{suffix}")
    assert_same(read_trial(folder / f"t{suffix}"), trial)
    assert_same(read_trial(folder / "t.toml"), trial)


def test_the_files_are_those_of_the_sheet(tmp_path: Path) -> None:
    """The text on disk, written out: other programs read it."""
    header = make_header(BENCH, kind="servo_bench", joints=("arm", "wrist"), gait="", notes="a\nb")
    columns = (
        TableColumn("time_s", np.array([0.0, 0.01])),
        TableColumn("command_arm_rad", np.array([0.5, np.nan])),
        TableColumn("pwm_arm", np.array([-1.0, 1.0])),
        TableColumn("torque_wrist_nm", np.array([0.1, 0.2])),
    )
    write_trial(build_trial(header, columns), tmp_path / "bench.csv")
    assert (tmp_path / "bench.csv").read_text() == (
        "time_s,command_arm_rad,pwm_arm,torque_wrist_nm\n"
        "0.0,0.5,-1.0,0.1\n"
        "0.01,,1.0,0.2\n"
    )  # fmt: skip
    assert (tmp_path / "bench.toml").read_text() == (
        '[trial]\nrobot = "machine.toml"\ngait = ""\nfrequency_hz = 0.1\n'
        'sample_rate_hz = 100.0\nnotes = "a\\nb"\n\n[noise]\nforce_n = 0.15\n'
    )
    assert (tmp_path / "machine.toml").read_text() == BENCH


def test_a_hand_written_trial_of_a_sliding_body(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("time_s,body_x_m,body_yaw_rad\n0,1,-0.5\n0.5,,NaN\n")
    (tmp_path / "s.toml").write_text('[trial]\nrobot = "disc.toml"\n')
    (tmp_path / "disc.toml").write_text(SLIDER)
    trial = read_trial(tmp_path / "s.csv")
    assert trial.header.kind == "sliding_body"
    assert trial.joints == ()
    np.testing.assert_array_equal(trial.body_position_m[:, 0], [1.0, np.nan])
    assert np.isnan(trial.body_position_m[:, 1:]).all(), "absent is NaN, not 0"
    np.testing.assert_array_equal(trial.body_angles_rad[:, 2], [-0.5, np.nan])
    assert trial.shaft_rad.shape == (2, 0)
    assert np.isnan(trial.header.frequency_hz)


def test_joints_are_not_legs(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("time_s,shaft_hip_rad,shaft_knee_rad,force_LF_z_n\n0,1,2,3\n")
    (tmp_path / "t.toml").write_text('[trial]\nrobot = "dog.xml"\n')
    (tmp_path / "dog.xml").write_text("<mujoco/>")
    trial = read_trial(tmp_path / "t.csv")
    assert trial.header.kind == "mjcf"
    assert (trial.joints, trial.legs) == (("hip", "knee"), ("LF",))
    (tmp_path / "t.toml").write_text(
        '[trial]\nrobot = "dog.xml"\njoints = ["hip", "knee"]\nlegs = ["LF"]\n'
        '[conditions]\nfloor = "mat"\npayload_kg = 2\n[constants]\nkp = [20, 30]\nkd = 1.5\n'
        '[drive]\nkind = "pd"\n'
    )
    trial = read_trial(tmp_path / "t.csv")
    assert (trial.joints, trial.legs) == (("hip", "knee"), ("LF",))
    assert trial.force_n[0, 0, 2] == 3
    header = trial.header
    assert (header.condition("floor"), header.condition("payload_kg")) == ("mat", 2.0)
    assert header.condition("gait") is None
    assert (header.constant("kp"), header.constant("kd")) == ((20.0, 30.0), (1.5, 1.5))
    assert header.drive.strip() == 'kind = "pd"'
    assert Path(header.folder) == tmp_path


def test_a_bench_has_no_legs(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("time_s,shaft_arm_rad\n0,1\n")
    (tmp_path / "t.toml").write_text('[trial]\nrobot = "m.toml"\n')
    (tmp_path / "m.toml").write_text(BENCH)
    trial = read_trial(tmp_path / "t.csv")
    assert trial.legs == ()
    assert trial.foot_m.shape == (1, 0, 3)


def test_legs_that_no_machine_names_are_those_of_the_columns(tmp_path: Path) -> None:
    names = "time_s,shaft_L1_rad,shaft_L1_rad_s,foot_R_2_x_m,force_R_2_z_n,pwm_w"
    (tmp_path / "t.csv").write_text(f"{names}\n0,1,2,3,4,5\n")
    (tmp_path / "t.toml").write_text("[trial]\n")
    trial = read_trial(tmp_path / "t.csv")
    assert trial.joints == ("L1", "R_2", "w")
    assert trial.shaft_rad_s[0, 0] == 2
    assert trial.foot_m[0, 1, 0] == 3
    assert trial.force_n[0, 1, 2] == 4
    assert trial.pwm[0, 2] == 5


def test_some_samples_of_a_trial() -> None:
    trial = make_trial(make_header())
    keep = trial.time_s >= 0.2
    part = trial.rows(keep)
    assert len(part.time_s) == 10
    np.testing.assert_array_equal(part.force_n, trial.force_n[20:])
    assert part.header is trial.header
    assert not part.force_n.flags.writeable


def test_a_column_without_a_number_is_left_out(tmp_path: Path) -> None:
    columns = (TableColumn("time_s", np.array([0.0])), TableColumn("pwm_HL", np.array([np.nan])),
               TableColumn("voltage_FR_v", np.array([12.0])))  # fmt: skip
    write_trial(build_trial(make_header(), columns), tmp_path / "t.parquet")
    assert read_table(tmp_path / "t.parquet").names == ("time_s", "voltage_FR_v")


WRONG_TOML = {
    "gait = 1": r"t\.toml: trial\.gait: must be a text, not 1",
    "frequency_hz = '1'": r"trial\.frequency_hz: must be a number, not '1'",
    "sample_rate_hz = true": r"trial\.sample_rate_hz: must be a number, not True",
    "legs = 'HL'": r"trial\.legs: must be a list of texts",
    "legs = ['HL', 'HL']": r"trial\.legs: names must differ from each other",
    "legs = ['a b']": r"'a b' is no name of a leg or joint",
    "frequenzy_hz = 1": r"trial\.frequenzy_hz: is not a known key; did you mean 'frequency_hz'\?",
    "robot = 'none.toml'": r"none\.toml cannot be read: No such file",
    "robot = 'bad.toml'": r"bad\.toml is not valid TOML",
    "robot = 'odd.toml'": r"odd\.toml: kind must be the name of a kind of machine, .* not 'big cat'",
    "[noise]\nforce = 1": r"noise\.force: is not a known key; did you mean 'force_n'\?",
    "[nois]": r"nois: is not a known key; did you mean 'noise'\?",
    "[[trial.x]]": r"trial\.x: is not a known key",
    "=": r"t\.toml is not valid TOML",
}


@pytest.mark.parametrize("line", WRONG_TOML)
def test_a_wrong_toml_is_an_error_that_says_what_is_wrong(tmp_path: Path, line: str) -> None:
    (tmp_path / "bad.toml").write_text("==")
    (tmp_path / "odd.toml").write_text("kind = 'big cat'")
    (tmp_path / "t.csv").write_text("time_s\n0\n")
    (tmp_path / "t.toml").write_text(f"[trial]\n{line}\n")
    with pytest.raises(RecordError, match=WRONG_TOML[line]):
        read_trial(tmp_path / "t.csv")


WRONG_TABLE = {
    "": r"cannot be read",
    "shaft_HL_rad\n0\n": r"has no column time_s",
    "time_s,time_s\n0,0\n": r"two columns time_s",
    "time_s,shaft_XX_rad\n0,0\n": r"shaft_XX_rad: no column of a trial of joints HL.*bigant import",
    "time_s,pwm_HL\n0,full\n": r"pwm_HL holds text that is no number, 'full'",
    "time_s,pwm_HL\n0,1\n0,2\n": r"does not increase everywhere; repair it: bigant import",
    "time_s,pwm_HL\n1,1\n0,2\n": r"does not increase everywhere",
    "time_s,pwm_HL\n,1\n1,2\n": r"does not increase everywhere",
    "time_s,pwm_HL\n0\n": r"cannot be read: line 2 has 1 fields, and the first line 2",
}


@pytest.mark.parametrize("table", WRONG_TABLE)
def test_a_wrong_table_is_an_error_that_says_what_is_wrong(tmp_path: Path, table: str) -> None:
    (tmp_path / "t.csv").write_text(table)
    (tmp_path / "t.toml").write_text(f"[trial]\nlegs = {list(LEGS)}\n")
    with pytest.raises(RecordError, match=WRONG_TABLE[table]):
        read_trial(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.csv", r"none\.csv cannot be read"),
        ("none.toml", r"there is no none\.parquet or none\.csv beside"),
        ("none.xlsx", r"must end in \.parquet or \.csv"),
    ],
)
def test_a_trial_that_is_not_there(tmp_path: Path, name: str, words: str) -> None:
    with pytest.raises(RecordError, match=words):
        read_trial(tmp_path / name)


CONTRADICTIONS = (
    (
        make_header(kind="servo_bench"),
        r"the trial is of a servo_bench, but its machine's file says legged",
    ),
    (make_header(BENCH), r"the trial is of a legged, but its machine's file says servo_bench"),
    (make_header(HEXAPOD, robot_file=""), r"needs a name for its file"),
    (make_header(HEXAPOD, robot_file="t.toml"), r"would be the machine's file too"),
    (make_header(robot_text="=", robot_file="m.toml"), r"m\.toml is not valid TOML"),
    (make_header(joints=("a", "a")), r"legs must differ"),
    (make_header(joints=("",)), r"'' is no name"),
)


@pytest.mark.parametrize(("header", "words"), CONTRADICTIONS, ids=[w for _, w in CONTRADICTIONS])
def test_what_would_not_read_back_is_not_written(
    tmp_path: Path, header: TrialHeader, words: str
) -> None:
    with pytest.raises(RecordError, match=words):
        write_trial(make_trial(header), tmp_path / "t.parquet")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("times", [[0.0, 0.0], [1.0, 0.0], [0.0, np.nan], [0.0, np.inf]])
def test_time_that_does_not_increase_is_not_written(tmp_path: Path, times: list[float]) -> None:
    trial = build_trial(make_header(), (TableColumn("time_s", np.array(times)),))
    with pytest.raises(RecordError, match="time_s does not increase everywhere"):
        write_trial(trial, tmp_path / "t.csv")
    assert list(tmp_path.iterdir()) == []


def test_two_trials_of_one_machine_share_its_file_but_not_with_another(tmp_path: Path) -> None:
    write_trial(make_trial(make_header(HEXAPOD)), tmp_path / "a.parquet")
    write_trial(make_trial(make_header(HEXAPOD), seed=1), tmp_path / "b.parquet")
    other = make_header(HEXAPOD + "# changed\n")
    with pytest.raises(
        RecordError, match=r"machine\.toml is another machine's file than this trial's"
    ):
        write_trial(make_trial(other), tmp_path / "c.parquet")
    assert (tmp_path / "machine.toml").read_bytes() == HEXAPOD.encode()
    assert_same(read_trial(tmp_path / "a.parquet"), make_trial(make_header(HEXAPOD)))
