"""Files of one run with clocks of their own: known offsets come back within what is said of them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.trial.clock_alignment import ClockEvent, FileClock, align
from record.trial.column_map import read_column_map
from record.trial.header import LEGGED, TrialHeader
from record.trial.import_run import import_run
from record.trial.import_table import Imported
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

HEADER = TrialHeader(LEGGED, ("L",))
BY_COLUMNS = FileClock(by="correlation", columns=("shaft_L_rad", "foot_L_x_m"))


def measured(time_s: FloatArray, **columns: FloatArray) -> Trial:
    each = [TableColumn(name, values) for name, values in columns.items()]
    return build_trial(HEADER, [TableColumn("time_s", time_s), *each])


def wandering(rng: np.random.Generator, seconds: float = 40.0) -> tuple[FloatArray, FloatArray]:
    """A motion that begins and ends at rest: its times and places at 1 kHz."""
    time_s = np.arange(0, seconds, 1e-3)
    speed = gaussian_filter1d(rng.normal(size=len(time_s)), 150)
    resting = (time_s < 5) | (time_s > seconds - 5)
    return time_s, np.cumsum(np.where(resting, 0.0, speed)) * 1e-3 * 20


def test_known_offsets_are_recovered_within_the_stated_uncertainty() -> None:
    """Two rates, a scale, noise of a twentieth of the motion: 20 offsets, errors in units of their sd."""
    rng, errors = np.random.default_rng(0), []
    for _ in range(20):
        fine_s, motion = wandering(rng)
        size = motion.std()
        later_s = float(rng.uniform(-300, 300))
        here_s = np.arange(0.0, 38, 0.01)
        there_s = np.arange(1.3, 39, 0.0083)
        base = measured(
            here_s, shaft_L_rad=np.interp(here_s, fine_s, motion) + rng.normal(0, 0.02 * size, len(here_s))
        )  # fmt: skip
        shown = 0.3 * np.interp(there_s, fine_s, motion)
        other = measured(
            there_s - later_s, foot_L_x_m=shown + rng.normal(0, 0.006 * size, len(there_s))
        )
        found = align(base, other, BY_COLUMNS, None)
        assert found.sd_s < 0.05
        errors.append((found.later_s - later_s) / found.sd_s)
    assert np.sqrt(np.mean(np.square(errors))) < 2
    assert np.abs(errors).max() < 4


def test_a_motion_that_repeats_itself_is_refused_with_what_to_do() -> None:
    time_s = np.arange(0, 30, 0.01)
    rng = np.random.default_rng(1)
    swing = np.sin(2 * np.pi * time_s)
    base = measured(time_s, shaft_L_rad=swing + rng.normal(0, 0.01, len(time_s)))
    other = measured(time_s + 9, foot_L_x_m=swing + rng.normal(0, 0.01, len(time_s)))
    with pytest.raises(RecordError, match="the motion repeats itself; begin and end recordings"):
        align(base, other, BY_COLUMNS, None)


def test_signals_of_different_motions_are_refused() -> None:
    rng = np.random.default_rng(2)
    (fine_s, one), (_, two) = wandering(rng), wandering(rng)
    base, other = (
        measured(fine_s[::10], shaft_L_rad=one[::10]),
        measured(fine_s[::10], foot_L_x_m=two[::10]),
    )
    with pytest.raises(RecordError, match=r"not alike|fits as well"):
        align(base, other, BY_COLUMNS, None)


def test_an_event_aligns_to_half_a_sample_of_each() -> None:
    tap_s, later_s = 3.1416, 100.0
    here_s, there_s = np.arange(0, 10, 0.01), np.arange(0, 12, 0.005)
    base = measured(here_s, force_L_z_n=np.where(here_s >= tap_s, 50.0, 0.1))
    place = np.where(there_s >= tap_s, 0.19, 0.2)
    other = measured(there_s - later_s, body_z_m=place)
    clock = FileClock(
        by="event",
        here=ClockEvent("force_L_z_n", "above", 30.0),
        there=ClockEvent("body_z_m", "moved", 0.005),
    )
    found = align(base, other, clock, None)
    assert abs(found.later_s - later_s) < 0.0075
    assert found.sd_s == pytest.approx(np.hypot(0.01, 0.005) / np.sqrt(12))
    never = FileClock(by="event", here=ClockEvent("force_L_z_n", "above", 99.0), there=clock.there)
    with pytest.raises(RecordError, match="never happens in the run's table"):
        align(base, other, never, None)
    always = FileClock(by="event", here=ClockEvent("force_L_z_n", "above", 0.0), there=clock.there)
    with pytest.raises(RecordError, match="is so from the beginning"):
        align(base, other, always, None)
    absent = FileClock(by="event", here=ClockEvent("shaft_L_rad", "above", 0.0), there=clock.there)
    with pytest.raises(RecordError, match="there is no shaft_L_rad to align by"):
        align(base, other, absent, None)


RUN = "time_s,shaft_L_rad\n" + "".join(f"{k / 10},{k / 10}\n" for k in range(10))
MOCAP = "t;x\n" + "".join(f"{1000 + 200 * k};{100 * k}\n" for k in range(6))
MAP = """
[trial]
legs = ["L"]
[file.mocap]
path = "{name}_mocap.csv"
[file.mocap.table]
delimiter = ";"
[file.mocap.columns]
time_s = { from = "t", unit = "ms" }
body_x_m = { from = "x", unit = "mm" }
"""


def brought(folder: Path, clock: str) -> Imported:
    (folder / "run.csv").write_text(RUN)
    (folder / "run_mocap.csv").write_text(MOCAP)
    (folder / "map.toml").write_text(f"{MAP}[file.mocap.clock]\n{clock}\n")
    (one,) = import_run(folder / "run.csv", read_column_map(folder / "map.toml"))
    return one


def test_another_file_is_put_on_the_table_s_times_and_it_is_said_and_kept(tmp_path: Path) -> None:
    """Places 0, 0.1 ... 0.5 m at 1, 1.2 ... 2 s of their clock, which is 0.9 s ahead."""
    one = brought(tmp_path, 'by = "offset"\nseconds = -0.9')
    assert one.trial is not None
    wanted = [np.nan, 0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]
    np.testing.assert_allclose(one.trial.body_position_m[:, 0], wanted, atol=1e-12)
    (finding,) = [f for f in one.report.findings if f.kind == "clock"]
    assert (finding.column, finding.detail) == ("mocap", "run_mocap.csv: -0.9 s as the map says")
    assert "clock of mocap: -0.9 s" in one.trial.header.derived[0]
    assert "body_x_m" in one.report.columns


@pytest.mark.parametrize(
    ("clock", "words"),
    [
        ('by = "guess"', "file.mocap.clock.by"),
        ('by = "event"', "file.mocap.clock.here"),
        ('by = "event"\nhere = { column = "shaft_L_rad" }', "needs one of above, below, moved"),
        (
            'by = "correlation"\ncolumns = ["a"]',
            "must be a column of the table and one of the file",
        ),
        ('by = "correlation"', "needs the machine's model"),
        ('by = "correlation"\ncolumns = ["shaft_L_rad", "body_y_m"]', "no body_y_m to align by"),
    ],
)
def test_a_clock_that_means_nothing_is_refused(clock: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(RecordError) as raised:
        brought(tmp_path, clock)
    assert words in str(raised.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    brought(tmp_path, 'by = "same"')
    (tmp_path / "run_mocap.csv").unlink()
    with pytest.raises(RecordError, match=r"run_mocap\.csv cannot be read"):
        next(import_run(tmp_path / "run.csv", read_column_map(tmp_path / "map.toml")))
