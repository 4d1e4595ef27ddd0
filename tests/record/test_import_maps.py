"""Column maps for what others measured: hidden signs, dates, arrays, cuts; the maps that are shipped."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

from model.errors import RecordError
from record.trial.column_map import ColumnMap, find_map, map_names, read_column_map
from record.trial.import_table import ImportReport, import_tables
from record.trial.table_check import TableFinding
from record.trial.trial import Trial, read_trial
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode

SERVO = 'kind = "servo_bench"\n[joint.arm]\n'
HEAD = '[trial]\nrobot = "arm_robot.toml"\n'


def a_map(folder: Path, text: str) -> ColumnMap:
    (folder / "arm_robot.toml").write_text(SERVO)
    (folder / "map.toml").write_text(text + HEAD)
    return read_column_map(folder / "map.toml")


def bring(path: Path, given: ColumnMap) -> tuple[Trial, ImportReport]:
    (one,) = import_tables(path, given)
    assert one.trial is not None
    return one.trial, one.report


def kinds(findings: tuple[TableFinding, ...]) -> set[tuple[str, str]]:
    return {(one.kind, one.column) for one in findings}


def test_registers_with_a_sign_bit_dates_and_wrapped_numbers_come_in_with_their_sign(
    tmp_path: Path,
) -> None:
    rows = ["when,pos,speed,low"]
    for i in range(8):
        speed = (40 + i) if i % 2 else 32768 + 40 + i  # the sign is in bit 15
        low = i if i % 2 else 65536 - i - 1  # two's complement of 16 bits
        rows.append(f"2026-01-01T00:00:0{i}.500Z,{2048 + i},{speed},{low}")
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    given = a_map(
        tmp_path,
        """
        [columns]
        time_s = { from = "when", unit = "iso8601" }
        shaft_arm_rad = { from = "pos", unit = "ticks_4096" }
        shaft_arm_rad_s = { from = "speed", unit = "ticks_4096", sign_bit = 15 }
        current_arm_a = { from = "low", unit = "mA", signed_bits = 16 }
        """,
    )
    trial, report = bring(tmp_path / "log.csv", given)
    np.testing.assert_allclose(trial.time_s, np.arange(8.0))
    sign = np.where(np.arange(8) % 2, 1, -1)
    np.testing.assert_allclose(
        trial.shaft_rad_s[:, 0], sign * (40 + np.arange(8)) * 2 * np.pi / 4096
    )
    np.testing.assert_allclose(
        trial.current_a[:, 0], [-1e-3, 1e-3, -3e-3, 3e-3, -5e-3, 5e-3, -7e-3, 7e-3]
    )
    assert {("wrap", "speed"), ("wrap", "low")} <= kinds(report.findings)
    assert all("read so" in f.detail for f in report.findings if f.kind == "wrap")


def test_a_hidden_sign_that_the_map_does_not_know_is_named(tmp_path: Path) -> None:
    rows = [f"{i},{100 + i if i < 10 else 1024 + i}" for i in range(20)]
    (tmp_path / "log.csv").write_text("time_s,load\n" + "\n".join(rows) + "\n")
    given = a_map(tmp_path, "[columns]\npwm_arm = { from = 'load', scale = 0.001 }\n")
    _, report = bring(tmp_path / "log.csv", given)
    (found,) = [one for one in report.findings if one.kind == "wrap"]
    assert "sign_bit = 10" in found.detail
    assert (found.count, found.first_row) == (10, 11)


@pytest.mark.parametrize(
    "values", [range(0, 4096, 64), range(2000, 2100), range(20)], ids=["turn", "held", "small"]
)
def test_plain_counts_have_no_hidden_sign(tmp_path: Path, values: range) -> None:
    rows = [f"{i},{value}" for i, value in enumerate(values)]
    (tmp_path / "log.csv").write_text("time_s,pos\n" + "\n".join(rows) + "\n")
    given = a_map(tmp_path, "[columns]\nshaft_arm_rad = { from = 'pos', unit = 'ticks_4096' }\n")
    _, report = bring(tmp_path / "log.csv", given)
    assert not [one for one in report.findings if one.kind == "wrap"]


def test_sides_of_two_pullers_add_up_and_empty_rows_are_named(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(
        "time_s,goal,pos,a,b\n0,5,,,\n1,5,1,100,200\n2,5,2,150,200\n3,5,3,100,140\n"
    )
    given = a_map(
        tmp_path,
        """
        [columns]
        command_arm_rad = "goal"
        shaft_arm_rad = "pos"
        torque_arm_nm = [
            { from = "a", rest = 100, beyond = 30, sign = -1, scale = 0.1 },
            { from = "b", rest = 200, beyond = 30, sign = -1, scale = 0.1 },
        ]
        """,
    )
    trial, report = bring(tmp_path / "log.csv", given)
    np.testing.assert_allclose(trial.torque_nm[:, 0], [np.nan, 0, -0.1, 0.1])
    (empty,) = [one for one in report.findings if one.kind == "empty"]
    assert (empty.count, empty.first_row) == (1, 1)


def test_arrays_of_a_file_are_columns(tmp_path: Path) -> None:
    t = np.arange(30) * 0.02
    pos = np.column_stack([np.sin(t), np.cos(t)])
    np.savez(tmp_path / "one.npz", t=t, cmd=pos, pos=pos + 0.1, other=np.zeros(7))
    given = a_map(
        tmp_path,
        '[columns]\ntime_s = "t"\ncommand_arm_rad = "cmd[1]"\nshaft_arm_rad = "pos[1]"\n',
    )
    trial, report = bring(tmp_path / "one.npz", given)
    np.testing.assert_array_equal(trial.command_rad[:, 0], np.cos(t))
    np.testing.assert_array_equal(trial.shaft_rad[:, 0], np.cos(t) + 0.1)
    assert {("ignored", "other"), ("ignored", "pos[0]")} <= kinds(report.findings)


CUT = """
[table]
each_array = true
period_s = 0.01
[columns]
shaft_arm_rad = "0"
[cut]
settled = [{ columns = ["1"], norm_below = 0.5 }, { columns = ["0"], from_end_below = 4.0 }]
moving = [{ columns = ["2"], norm_above = 0.5 }]
fewest_rows = 10
"""


def test_each_array_is_a_trial_cut_to_where_it_is_settled_and_moves(tmp_path: Path) -> None:
    rows = np.arange(100.0)
    tumbling = np.where(rows < 40, 1.0, 0.0)
    moving = np.where(rows < 70, 1.0, 0.0)
    long = np.column_stack([rows / 100, tumbling, moving])
    short = np.column_stack([rows / 100, np.where(rows < 65, 1.0, 0.0), moving])
    with zipfile.ZipFile(
        tmp_path / "tosses.npz", "w"
    ) as file:  # np.savez takes no such names typed
        for name, one in (("0", long), ("10", short)):
            with file.open(f"{name}.npy", "w") as entry:
                np.save(entry, one)
    first, second = import_tables(tmp_path / "tosses.npz", a_map(tmp_path, CUT))
    assert first.trial is not None
    np.testing.assert_allclose(first.trial.time_s, np.arange(40, 70) * 0.01)
    assert first.report.name == "00"
    (cut,) = [one for one in first.report.findings if one.kind == "cut"]
    assert (cut.count, cut.detail.count("40 rows before"), cut.detail.count("30 at")) == (70, 1, 1)
    assert second.trial is None
    assert second.report.kept == 0
    assert ("short", "") in kinds(second.report.findings)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "[columns]\ntime_s = { from = 't', sign_bit = 40 }\n",
            "sign_bit: must be from 0 to 31, not 40",
        ),
        ("[columns]\nshaft_arm_rad = { from = 't', unit = 'iso8601' }\n", "for time_s only"),
        ("[cut]\nsettled = [{ columns = ['a'] }]\n", "one of norm_below"),
        ("[cut]\nfewest_rows = -1\n", "fewest_rows: must be from 0"),
        ("[table]\nperiod_s = 0\n", "above 0"),
        ("[table]\neach_array = 1\n", "true or false"),
    ],
)
def test_a_wrong_key_is_an_error_that_says_what_is_wrong(
    tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises(RecordError, match=words):
        a_map(tmp_path, text)


@pytest.mark.parametrize("name", map_names())
def test_maps_that_are_shipped_name_their_machine_and_its_licence(name: str) -> None:
    given = read_column_map(find_map(name))
    assert given.sources
    assert given.about.what
    assert given.about.source
    assert given.about.licence
    header = given.header
    if given.form is not None:  # a set whose files are called after their conditions
        header = given.form.header_of("kp100_sin_sin", {})
    assert header is not None
    assert header.kind in {"servo_bench", "sliding_body"}
    for source in given.sources:
        for joint in header.joints:
            if f"_{joint}_" in source.ours:
                break
        else:
            assert source.ours == "time_s" or source.ours.startswith(("body_", "pwm_"))


def test_a_map_that_is_not_there_is_one_line_with_the_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert map_names() == ("servo_backlash", "sliding_cube", "so101", "xl330")
    (tmp_path / "a.csv").write_text("time_s,pwm_a\n0,1\n")
    words = ["import", str(tmp_path / "a.csv"), "--map", "so100"]
    assert cli.run(words) == ExitCode.USAGE
    assert "did you mean so101?" in capsys.readouterr().err


def test_several_tables_become_trials_in_a_folder_and_one_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(120) * 0.02
    for name in ("a", "b"):
        current = np.abs(np.sin(9 * t)) + 0.01
        np.savez(tmp_path / f"{name}.npz", t=t, cmd=np.sin(9 * t), pos=np.sin(9 * t), i=current)
    a_map(
        tmp_path,
        '[columns]\ntime_s = "t"\ncommand_arm_rad = "cmd"\nshaft_arm_rad = "pos"\n'
        'current_arm_a = "i"\n',
    )
    files = [str(tmp_path / f"{name}.npz") for name in ("a", "b")]
    words = ["import", *files, "--map", str(tmp_path / "map.toml"), "--out"]
    assert cli.run([*words, str(tmp_path / "one.parquet")]) == ExitCode.USAGE
    capsys.readouterr()
    assert cli.run([*words, str(tmp_path / "out")]) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "2 files, 2 tables: 240 rows, 240 kept, 0 dropped" in printed
    assert "fault   magnitude_only current_arm_a in all 2" in printed
    assert printed.endswith("out: 2 trials, 240 samples\n")
    trial = read_trial(tmp_path / "out" / "b.parquet")
    assert (trial.header.kind, trial.joints) == ("servo_bench", ("arm",))
