"""``bigant log ...`` and ``bigant import`` as a person types them, on a walk of the virtual robot."""

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from model.values.faults import StopReason
from model.values.tick import Mode
from record.log.blocks.read import read_log
from record.log.header import PACKAGES
from record.log.reader import LogContents, read_ticks
from record.trial.table_file import read_table
from record.trial.trial import read_trial
from robot.cli import main as cli
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode

Capture = pytest.CaptureFixture[str]


def bigant(*words: object) -> int:
    return cli.run([str(w) for w in words])


def cut_short(path: Path, folder: Path, share: float) -> Path:
    short = folder / "short.mcap"
    data = path.read_bytes()
    short.write_bytes(data[: int(len(data) * share)])
    return short


def test_a_log_is_complete(short_walk: Path) -> None:
    """Counts of both devices, every stage, verdicts, robot file and versions of the software."""
    contents = LogContents()
    ticks = list(read_ticks(short_walk, contents))
    servos = [t.inputs.servos for t in ticks if t.inputs.servos is not None]
    assert len(servos) > len(ticks) - 5
    assert all(s.valid.all() and (s.position_ticks > 0).all() for s in servos)
    assert len({tuple(s.position_ticks) for s in servos}) > 50, "counts, not one copied value"
    records = [record for t in ticks for record in t.inputs.forces]
    assert len(records) > len(ticks) / 2
    assert all(r.present.all() and r.counts.any() for r in records)
    walk = [t for t in ticks if t.mode is Mode.WALK]
    assert walk
    assert all(np.isfinite(t.wished.angle_rad).all() for t in walk)
    assert all(t.sent.torque and np.isfinite(t.sent.angle_rad).all() for t in walk)
    assert all(t.joints.valid.all() and t.forces.valid.all() for t in walk)
    assert all(t.contact.support.converged and t.contact.traction.valid for t in walk)
    assert all(t.dead_reckoning.valid and t.inputs.truth is not None for t in walk)
    assert ticks[-1].stop_reason is not StopReason.NONE
    assert contents.config_text == DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    for package in ("python", *PACKAGES):
        assert contents.metadata[f"version.{package}"][0].isdigit(), package


def test_info_says_what_is_there(short_walk: Path, capsys: Capture) -> None:
    assert bigant("log", "info", short_walk) == ExitCode.OK
    printed = capsys.readouterr().out
    for words in (
        "BigANT",
        "tripod at 0.2 Hz on virtual",
        "100 Hz",
        "/wrench/HL",
        "numpy 2",
        "none",
    ):
        assert words in printed
    assert bigant("log", "info", short_walk, "--json") == ExitCode.OK
    found = json.loads(capsys.readouterr().out)
    assert found["ticks"] == len(list(read_ticks(short_walk)))
    assert found["rate_hz"] == pytest.approx(100)
    assert found["finished"] is True
    assert found["damage"] == []
    assert found["metadata"]["version.numpy"] == np.__version__


def test_info_of_a_cut_log_says_so(short_walk: Path, tmp_path: Path, capsys: Capture) -> None:
    short = cut_short(short_walk, tmp_path, 0.6)
    assert bigant("log", "info", short) == ExitCode.VERDICT_FAILED
    assert "the file ends early" in capsys.readouterr().out
    bigant("log", "info", short, "--json")
    found = json.loads(capsys.readouterr().out)
    (damage,) = found["damage"]
    assert damage["reason"] == "the file ends early"
    assert damage["from_s"] == pytest.approx(read_log(short).t_s[-1], abs=0.02)
    assert damage["to_s"] is None


def test_a_cut_log_is_repaired_beside_itself(
    short_walk: Path, tmp_path: Path, capsys: Capture
) -> None:
    short = cut_short(short_walk, tmp_path, 0.6)
    before = short.read_bytes()
    assert bigant("log", "repair", short) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "lost: the file ends early" in printed
    mended = tmp_path / "short.repaired.mcap"
    assert short.read_bytes() == before
    assert bigant("log", "info", mended) == ExitCode.OK
    assert len(read_log(mended).t_s) == len(read_log(short).t_s)
    capsys.readouterr()
    assert bigant("log", "repair", short) == ExitCode.LOG
    assert "is there already; name another file with --out" in capsys.readouterr().err


def test_pieces_and_merged_logs_open_everywhere(short_walk: Path, tmp_path: Path) -> None:
    one, two, both = tmp_path / "1.mcap", tmp_path / "2.mcap", tmp_path / "both.mcap"
    assert bigant("log", "trim", short_walk, "--to", "0.3", "--out", one) == ExitCode.OK
    assert bigant("log", "trim", short_walk, "--from", "0.5", "--out", two) == ExitCode.OK
    assert bigant("log", "merge", two, one, "--out", both) == ExitCode.OK
    log = read_log(both)
    assert np.diff(log.t_s).max() == pytest.approx(0.21, abs=0.02), "the gap is kept"
    assert bigant("show", both, "--json") == ExitCode.OK
    with AnyReader([both]) as reader:
        ticks = [c for c in reader.connections if c.topic == "/bigant/tick"]
        assert sum(1 for _ in reader.messages(ticks)) == len(log.t_s)
    with both.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.attachment_count == 1


def test_exported_odometry_is_the_estimator_s_and_dead_reckoning_is_named_so(
    tmp_path: Path,
) -> None:
    path, table = Path(__file__).parent / "logs" / "format_2.mcap", tmp_path / "t.csv"
    words = ("log", "export", path, "--format")
    assert bigant(*words, "csv", "--what", "odometry", "--out", table) == ExitCode.OK
    found = {column.name: column.values[-1] for column in read_table(table).columns}
    assert found["estimate_x_m"] == pytest.approx(9.113805092770e-4)
    assert found["estimate_yaw_rad"] == pytest.approx(-1.2525705652e-05)
    assert found["dead_reckoning_x_m"] == pytest.approx(6.559878664779e-3)
    assert found["dead_reckoning_yaw_rad"] == pytest.approx(-0.029529677781586)
    assert bigant(*words, "tum", "--out", tmp_path / "p") == ExitCode.OK
    last = {kind: np.loadtxt(tmp_path / f"p_{kind}.tum")[-1] for kind in ("estimate", "truth")}
    assert last["estimate"][1:3] == pytest.approx([9.11381e-4, 1.50084e-4], abs=1e-9)
    assert last["estimate"][0] == last["truth"][0]


def test_every_export_and_back(short_walk: Path, tmp_path: Path, capsys: Capture) -> None:
    trial = tmp_path / "t.parquet"
    count = len(list(read_ticks(short_walk)))
    assert bigant("log", "export", short_walk, "--format", "trial", "--out", trial) == ExitCode.OK
    for kind in ("csv", "parquet"):
        out = tmp_path / f"table.{kind}"
        words = ("--format", kind, "--what", "joints,raw", "--out", out)
        assert bigant("log", "export", short_walk, *words) == ExitCode.OK
        assert f"{out}: {count} rows" in capsys.readouterr().out
    assert (
        bigant("log", "export", short_walk, "--format", "tum", "--out", tmp_path / "p")
        == ExitCode.OK
    )
    assert {p.name for p in tmp_path.glob("*.tum")} == {
        "p_estimate.tum",
        "p_dead_reckoning.tum",
        "p_truth.tum",
    }
    back, report = tmp_path / "back.mcap", tmp_path / "report.json"
    capsys.readouterr()
    assert bigant("import", trial, "--out", back, "--report", report, "--json") == ExitCode.OK
    found = json.loads(report.read_text(encoding="utf-8"))
    assert json.loads(capsys.readouterr().out) == found
    assert (found["rows"], found["kept"], found["dropped"]) == (count, count, [])
    assert bigant("log", "export", back, "--format", "trial", "--out", tmp_path / "b.csv") == 0
    one, other = read_trial(trial), read_trial(tmp_path / "b.csv")
    np.testing.assert_array_equal(one.shaft_rad, other.shaft_rad)
    np.testing.assert_array_equal(one.force_n, other.force_n)
    assert one.header == other.header or repr(one.header) == repr(other.header)


def test_a_report_as_text_lists_every_dropped_row(tmp_path: Path, capsys: Capture) -> None:
    table, report = tmp_path / "t.csv", tmp_path / "report.txt"
    table.write_text("time_s,pwm_a\n" + "".join(f"{i // 30},0.5\n" for i in range(60)))
    assert bigant("import", table, "--report", report) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "60 rows, 2 kept, 58 dropped" in printed
    assert "48 more, all in --report FILE" in printed
    lines = report.read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("dropped") for line in lines) == 58
    assert "dropped  row 2: a copy of row 1" in lines


WRONG = (
    (("log", "info", "NONE"), "cannot be read: No such file"),
    (("log", "repair", "LOG", "--out", "LOG"), "is the log itself"),
    (("log", "trim", "LOG", "--from", "2", "--to", "1", "--out", "OUT.mcap"), "must lie after --from"),
    (("log", "trim", "LOG", "--from", "999", "--out", "OUT.mcap"), "has no data from 999"),
    (("log", "merge", "LOG", "LOG", "--out", "OUT.mcap"), "overlap by"),
    (("log", "merge", "LOG", "--out", "OUT.mcap"), "two logs or more"),
    (("log", "export", "LOG", "--format", "csv", "--what", "joint"), "choose from joints"),
    (("log", "export", "LOG", "--format", "csv", "--out", "OUT.xls"), "must end in .csv"),
    (("log", "export", "LOG", "--format", "tum", "--out", "x.csv"), "x_estimate.tum, not x.csv"),
    (("log", "export", "LOG", "--format", "tum", "--what", "truth"), "tum has its own"),
    (("import", "NONE.csv"), "there is no such file"),
    (("import", "LOG"), "is a log already: show, odom and gap take it as it is"),
    (("import", "TABLE", "--out", "OUT.xls"), "must end in .mcap, .parquet or .csv"),
    (("import", "TABLE", "--columns", "NONE"), "there is no map"),
    (("import", "TABLE", "--out", "TABLE"), "is the table itself"),
    (("import", "TABLE", "--report", "NONE/r.txt"), "choose another --report"),
)  # fmt: skip


@pytest.mark.parametrize(("words", "message"), WRONG, ids=[" ".join(w) for w, _ in WRONG])
def test_wrong_input_gives_one_clear_line(
    short_walk: Path, tmp_path: Path, capsys: Capture, words: tuple[str, ...], message: str
) -> None:
    table = tmp_path / "table.csv"
    table.write_text("time_s,pwm_a\n0,1\n1,1\n")
    places = {"LOG": str(short_walk), "TABLE": str(table)}
    filled = [
        places.get(w, w.replace("OUT", f"{tmp_path}/out").replace("NONE", f"{tmp_path}/none"))
        for w in words
    ]
    assert bigant(*filled) not in {0, 1}
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["table.csv"], "nothing is left behind"
