"""Cutting, merging and looking through logs."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from model.errors import BigantError, ConfigError, RecordError
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_stamped_ticks, read_ticks
from record.log.splice import cut_log, merge_logs
from record.log.survey import survey_log
from record.log.writer import LogWriter
from tests.record.test_log import START_UNIX_NS, same, write_log
from tests.record.ticks import NAMES, make_tick


def write_run(
    path: Path,
    count: int,
    *,
    start_s: float,
    config: str = "name = 'x'\n",
    robot: str = "BigANT",
    names: tuple[str, ...] = NAMES,
    skip: tuple[int, ...] = (),
) -> None:
    """A run that began at a time of its own, with its own clock from 1 s on."""
    writer = LogWriter(
        path, names=names, config_text=config,
        metadata={"robot": robot, "gait": path.stem}, start_ns=1_000_000_000,
        start_unix_ns=START_UNIX_NS + round(start_s * 1e9),
    )  # fmt: skip
    for index in range(count):
        if index not in skip:
            writer.write(make_tick(index, legs=len(names)))
    writer.close()
    assert writer.error is None


def test_a_survey_says_what_is_there(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    ticks = write_log(path, 120)
    survey = survey_log(path)
    assert (survey.ticks, survey.lost, survey.skipped) == (120, 0, 0)
    assert survey.period_s == pytest.approx(0.01)
    assert survey.duration_s == pytest.approx(1.19)
    assert survey.finished
    assert survey.damages == ()
    assert survey.config_text == "name = 'x'\n"
    counts = {topic.name: topic.count for topic in survey.topics}
    assert counts["/wrench/HL"] == 120
    assert counts["/odom_truth"] == sum(t.inputs.truth is not None for t in ticks)
    with path.open("rb") as stream:
        sizes: dict[str, int] = {}
        for _, channel, message in make_reader(stream).iter_messages():
            sizes[channel.topic] = sizes.get(channel.topic, 0) + len(message.data)
    assert {topic.name: topic.size for topic in survey.topics if topic.count} == sizes


def test_a_survey_counts_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write_run(path, 50, start_s=0, skip=(10, 11, 30))
    survey = survey_log(path)
    assert (survey.ticks, survey.lost, survey.skipped) == (47, 3, 0)
    writer = LogWriter(path, names=NAMES, config_text="", metadata={}, start_ns=0, start_unix_ns=0)
    for index in range(20):
        tick = make_tick(index)
        writer.write(replace(tick, t_ns=tick.t_ns + (50_000_000 if index >= 10 else 0)))
    writer.close()
    survey = survey_log(path)
    assert (survey.ticks, survey.lost, survey.skipped) == (20, 0, 5), "late is not lost"


def test_a_loop_that_is_late_all_the_time_is_told_by_the_rate_it_was_to_have(
    tmp_path: Path,
) -> None:
    path = tmp_path / "log.mcap"
    told = {"rate_hz": "100"}
    writer = LogWriter(
        path, names=NAMES, config_text="", metadata=told, start_ns=0, start_unix_ns=0
    )
    for index in range(20):
        tick = make_tick(index)
        writer.write(replace(tick, t_ns=tick.t_ns + index * 10_000_000))  # every second period
    writer.close()
    survey = survey_log(path)
    assert (survey.ticks, survey.lost, survey.skipped) == (20, 0, 19)
    assert survey.period_s == pytest.approx(0.01)


def test_a_piece_keeps_its_ticks_times_and_robot(tmp_path: Path) -> None:
    path, piece = tmp_path / "log.mcap", tmp_path / "piece.mcap"
    ticks = write_log(path, 60)
    done = cut_log(path, piece, from_s=0.195, to_s=0.395)
    contents = LogContents()
    back = list(read_ticks(piece, contents))
    assert [t.index for t in back] == list(range(20, 40))
    assert all(map(same, back, ticks[20:40]))
    assert contents.config_text == "name = 'x'\n"
    assert contents.metadata == survey_log(path).metadata
    assert read_log(piece).t_s[0] == pytest.approx(0.2), "times stay those of the run"
    assert done.kept == sum(topic.count for topic in survey_log(piece).topics)


def test_pieces_of_a_log_merge_into_the_log(tmp_path: Path) -> None:
    path, one, two, out = (tmp_path / f"{n}.mcap" for n in ("log", "one", "two", "out"))
    ticks = write_log(path, 60)
    cut_log(path, one, from_s=-np.inf, to_s=0.305)
    cut_log(path, two, from_s=0.305, to_s=np.inf)
    merge_logs((two, one), out)
    assert all(map(same, read_ticks(out), ticks))
    assert survey_log(out).ticks == 60


@pytest.mark.parametrize(
    ("from_s", "to_s", "words"),
    [
        (1.0, 1.0, r"--to: 1 s must lie after --from 1"),
        (np.nan, 1.0, r"--to: 1 s must lie after --from nan"),
        (5.0, 6.0, r"has no data from 5 to 6 s; it covers 0\.00 to 0\.19 s"),
    ],
)
def test_an_empty_piece_is_an_error(tmp_path: Path, from_s: float, to_s: float, words: str) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 20)
    with pytest.raises(BigantError, match=words):
        cut_log(path, tmp_path / "piece.mcap", from_s=from_s, to_s=to_s)
    assert [p.name for p in tmp_path.iterdir()] == ["log.mcap"]


def test_merged_logs_keep_the_gap_and_the_order_of_time(tmp_path: Path) -> None:
    late, early, out = tmp_path / "late.mcap", tmp_path / "early.mcap", tmp_path / "out.mcap"
    write_run(late, 15, start_s=10)
    write_run(early, 20, start_s=0)
    merge_logs((late, early), out)
    stamped = list(read_stamped_ticks(out))
    assert len(stamped) == 35
    assert all(a.unix_ns < b.unix_ns for a, b in pairwise(stamped))
    log = read_log(out)
    assert log.t_s[19] == pytest.approx(0.19)
    assert log.t_s[20] == pytest.approx(10.0)
    assert log.config_text == "name = 'x'\n"
    assert log.metadata["gait"] == "early, late"
    assert log.metadata["merged"] == "early.mcap, late.mcap"
    survey = survey_log(out)
    assert (survey.ticks, survey.lost) == (35, 0)
    assert survey.skipped == pytest.approx(980, abs=1), "the gap"


def test_logs_that_do_not_fit_are_not_merged(tmp_path: Path) -> None:
    base, out = tmp_path / "base.mcap", tmp_path / "out.mcap"
    write_run(base, 20, start_s=0)
    others = {
        "overlap by 0.1": {"start_s": 0.09},
        "different robots .BigANT, Spot.": {"start_s": 9, "robot": "Spot"},
        "different robot files": {"start_s": 9, "config": "name = 'y'\n"},
        "different legs": {"start_s": 9, "names": ("L", "R", "M")},
    }
    for words, how in others.items():
        other = tmp_path / "other.mcap"
        write_run(other, 20, **how)  # type: ignore[arg-type]
        with pytest.raises(RecordError, match=words):
            merge_logs((base, other), out)
    with pytest.raises(ConfigError, match="two logs or more"):
        merge_logs((base,), out)
    write_run(other, 20, start_s=9)
    with pytest.raises(RecordError, match="is the log itself"):
        merge_logs((base, other), base)
    assert not out.exists()
