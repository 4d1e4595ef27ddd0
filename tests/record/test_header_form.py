"""Conditions from a run's name, and constants of its log: what a map writes into each trial's header."""

from pathlib import Path

import numpy as np
import pytest

from model.errors import RecordError
from record.trial.column_map import ColumnMap, read_column_map
from record.trial.header import TrialHeader
from record.trial.import_table import import_tables

COLUMNS = '[columns]\ntime_s = "t"\nshaft_hip_rad = "q[1]"\nshaft_knee_rad = "q[0]"\n'
MACHINE = 'kind = "servo_bench"\n[joint.hip]\n[joint.knee]\n'


def given(folder: Path, text: str) -> ColumnMap:
    (folder / "arm_7.toml").write_text(MACHINE)
    (folder / "map.toml").write_text(f'{COLUMNS}[trial]\nrobot = "arm_7.toml"\n{text}')
    return read_column_map(folder / "map.toml")


def imported(folder: Path, name: str, text: str) -> TrialHeader:
    path = folder / f"{name}.npz"
    np.savez(path, kp=[20.0, 30.0], names=np.array(["knee", "hip"]), mass=[4.0],
             t=np.arange(9) / 10, q=np.zeros((9, 2)))  # fmt: skip
    (one,) = import_tables(path, given(folder, text))
    assert one.trial is not None
    taken = {f.column: f.kind for f in one.report.findings if f.column in {"kp", "mass"}}
    assert taken == {"kp": "constant", "mass": "constant"}
    return one.trial.header


def test_a_log_s_own_numbers_of_each_joint_go_with_it_in_the_order_of_the_joints(
    tmp_path: Path,
) -> None:
    header = imported(tmp_path, "run", "")
    assert header.joints == ("hip", "knee")
    assert header.constant("kp") == (30.0, 20.0), (
        "q[1] is the hip, so the second number is its gain"
    )
    assert header.constant("mass") == (4.0, 4.0)
    assert header.constant("kd") == ()


def test_conditions_come_from_the_name_and_constants_from_them(tmp_path: Path) -> None:
    text = (
        '[conditions]\nfrom_name = "g{gain}_{motion}"\nfloor = "mat"\n'
        '[constants]\nki = { from = "gain", scale = 0.5 }\nkd = { from = "kp", scale = 2 }\n'
    )
    header = imported(tmp_path, "g100_sin_sin", text)
    assert dict(header.conditions) == {"gain": 100.0, "motion": "sin_sin", "floor": "mat"}
    assert header.constant("ki") == (50.0, 50.0)
    assert header.constant("kd") == (60.0, 40.0)


def test_each_run_may_name_a_machine_s_file_of_its_own(tmp_path: Path) -> None:
    text = '[conditions]\nfrom_name = "arm{size}"\n'
    form = given(tmp_path, text).form
    assert form is not None
    whole = (tmp_path / "map.toml").read_text().replace("arm_7.toml", "arm_{size}.toml")
    (tmp_path / "map.toml").write_text(whole)
    form = read_column_map(tmp_path / "map.toml").form
    assert form is not None
    assert form.header_of("arm7", {}).robot_file == "arm_7.toml"
    with pytest.raises(RecordError, match=r"arm_8\.toml cannot be read"):
        form.header_of("arm8", {})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '[conditions]\nfrom_name = "{a}-{b}"\n',
            r"'run' is not of the form '\{a\}-\{b\}'; rename",
        ),
        ('[conditions]\nfrom_name = "run"\n', "needs names in braces"),
        ('[conditions]\nfrom_name = "{a}{a}"\n', "each once"),
        ("[conditions]\nfloor = [1]\n", r"conditions\.floor: must be a text or a number"),
        ('[constants]\nkp = { from = "gain" }\n', "'gain' is no condition and no array"),
        ('[conditions]\nx = "mat"\n[constants]\nkp = { from = "x" }\n', "which is no number"),
        ('[constants]\nkp = "high"\n', "must be a number, or one a joint"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(RecordError, match=words):
        imported(tmp_path, "run", text)


def test_constants_of_another_number_of_joints_are_refused() -> None:
    header = TrialHeader("servo_bench", ("a", "b"), constants=(("kp", (1.0, 2.0, 3.0)),))
    with pytest.raises(RecordError, match="3 values for 2 joints"):
        header.constant("kp")
