"""Logs that are cut or damaged: what is whole comes back as it was, what is not is named."""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from model.errors import RecordError
from model.values.estimate import Health
from model.values.tick import Mode, Tick
from record.log.damage import Pass
from record.log.reader import LogContents, read_ticks
from record.log.rewrite import repair
from record.log.salvage import read_records
from tests.record.test_log import START_UNIX_NS, same, write_log
from tests.record.ticks import PERIOD_NS

COUNT = 120


@dataclass(frozen=True)
class Chunk:
    """A chunk as the library's own index knows it."""

    offset: int
    size: int
    first: int  # index of its first tick
    last: int

    @property
    def end(self) -> int:
        return self.offset + self.size


@dataclass(frozen=True)
class Whole:
    """An undamaged log."""

    data: bytes
    ticks: list[Tick]
    chunks: list[Chunk]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    path = tmp_path_factory.mktemp("log") / "log.mcap"
    ticks = write_log(path, COUNT)
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None

    def number(unix_ns: int) -> int:
        return (unix_ns - START_UNIX_NS) // PERIOD_NS

    chunks = [
        Chunk(c.chunk_start_offset, c.chunk_length, number(c.message_start_time),
              number(c.message_end_time))
        for c in summary.chunk_indexes
        if c.message_end_time > 0
    ]  # fmt: skip
    return Whole(path.read_bytes(), ticks, sorted(chunks, key=lambda c: c.offset))


def read(path: Path, data: bytes) -> tuple[list[Tick], LogContents]:
    path.write_bytes(data)
    contents = LogContents()
    return list(read_ticks(path, contents)), contents


def indexes(ticks: list[Tick]) -> list[int]:
    return [tick.index for tick in ticks]


@pytest.mark.parametrize("cuts", [12, pytest.param(300, marks=pytest.mark.thorough)])
def test_cut_at_random_places_it_reads_up_to_the_last_second(
    cuts: int, tmp_path: Path, whole: Whole
) -> None:
    """The chunk in which the cut lies is lost, nothing before it, and it is shorter than a second."""
    rng = np.random.default_rng(0)
    for cut in rng.integers(0, len(whole.data), cuts).tolist():
        back, contents = read(tmp_path / "cut.mcap", whole.data[:cut])
        complete = [chunk for chunk in whole.chunks if chunk.end <= cut]
        open_chunk = next((c for c in whole.chunks if c.end > cut), None)
        if complete:
            # a tick's messages may go on in the next chunk; the tick itself comes first
            assert indexes(back) == list(range(complete[-1].last + 1)), cut
            assert all(map(same, back, whole.ticks))
        if complete and open_chunk is not None:
            lost_s = (open_chunk.last - back[-1].index) * PERIOD_NS * 1e-9
            assert lost_s < 1.0
            assert contents.damages[-1].reason == "the file ends early"
            assert not contents.progress.finished


def middle(whole: Whole) -> int:
    return len(whole.chunks) // 2


def damaged_chunk(whole: Whole, at: int) -> bytes:
    data, chunk = bytearray(whole.data), whole.chunks[at]
    data[chunk.offset + chunk.size // 2] ^= 0xFF
    return bytes(data)


@pytest.mark.parametrize("indexed", [True, False])
def test_a_damaged_chunk_loses_itself_alone_and_is_named(
    tmp_path: Path, whole: Whole, indexed: bool
) -> None:
    at = middle(whole)
    chunk = whole.chunks[at]
    data = damaged_chunk(whole, at)
    end = len(data) if indexed else whole.chunks[-1].offset
    back, contents = read(tmp_path / "bad.mcap", data[:end])
    last = COUNT - 1 if indexed else whole.chunks[-2].last
    lost = set(range(last + 1)) - set(indexes(back))
    assert lost
    assert lost <= set(range(chunk.first, chunk.last + 1))
    assert all(same(tick, whole.ticks[tick.index]) for tick in back)
    damage = contents.damages[0]
    assert "a broken chunk" in damage.reason
    assert (damage.offset, damage.size) == (chunk.offset, chunk.size)
    assert damage.from_ns == START_UNIX_NS + chunk.first * PERIOD_NS
    assert damage.to_ns == START_UNIX_NS + chunk.last * PERIOD_NS
    assert f"from {chunk.first / 100:.2f} s to {chunk.last / 100:.2f} s" in contents.damage


def broken_frame(whole: Whole, at: int) -> bytes:
    """A chunk's length says more than the file holds."""
    data, chunk = bytearray(whole.data), whole.chunks[at]
    data[chunk.offset + 1 : chunk.offset + 9] = struct.pack("<Q", 1 << 60)
    return bytes(data)


def test_broken_framing_goes_on_at_the_next_chunk_of_the_index(
    tmp_path: Path, whole: Whole
) -> None:
    at = middle(whole)
    chunk, after = whole.chunks[at], whole.chunks[at + 1]
    back, contents = read(tmp_path / "bad.mcap", broken_frame(whole, at))
    lost = set(range(COUNT)) - set(indexes(back))
    assert lost
    assert lost <= set(range(chunk.first, chunk.last + 1))
    damage = contents.damages[0]
    assert damage.reason == "the framing of records is broken"
    assert (damage.offset, damage.size) == (chunk.offset, after.offset - chunk.offset)
    assert damage.to_ns == START_UNIX_NS + after.first * PERIOD_NS
    assert contents.progress.finished


def test_broken_framing_without_an_index_ends_the_reading(tmp_path: Path, whole: Whole) -> None:
    at = middle(whole)
    data = broken_frame(whole, at)[: whole.chunks[-1].offset]
    back, contents = read(tmp_path / "bad.mcap", data)
    assert indexes(back) == list(range(whole.chunks[at - 1].last + 1))
    damage = contents.damages[-1]
    assert damage.to_ns == -1
    assert damage.from_ns == START_UNIX_NS + whole.chunks[at - 1].last * PERIOD_NS


def test_channels_in_a_damaged_chunk_are_known_from_the_index(tmp_path: Path, whole: Whole) -> None:
    back, _ = read(tmp_path / "bad.mcap", damaged_chunk(whole, 0))
    assert indexes(back)[-1] == COUNT - 1


def test_a_damaged_index_loses_no_message_and_is_noticed(tmp_path: Path, whole: Whole) -> None:
    data = bytearray(whole.data)
    data[whole.chunks[0].end + 20] ^= 0xFF  # message indexes lie behind each chunk
    back, contents = read(tmp_path / "bad.mcap", bytes(data))
    assert indexes(back) == list(range(COUNT))
    (damage,) = contents.damages
    assert not damage.content
    assert "no message is lost" in contents.damage


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whatever_is_broken_no_wrong_tick_comes_back(
    tmp_path: Path, whole: Whole, data: st.DataObject
) -> None:
    """Bytes changed, a piece taken out, a tail cut off: what comes back was written, in order."""
    content = bytearray(whole.data)
    place = st.integers(0, len(content) - 1)
    for _ in range(data.draw(st.integers(1, 3))):
        content[data.draw(place)] = data.draw(st.integers(0, 255))
    begin = data.draw(place)
    size = data.draw(st.sampled_from([0, 0, 1, 100, 10_000]))
    del content[begin : begin + size]
    path = tmp_path / "broken.mcap"
    path.write_bytes(content)
    contents = LogContents()
    try:
        back = list(read_ticks(path, contents))
    except RecordError:
        return  # another program's log, as it seems; never another kind of error
    assert indexes(back) == sorted(set(indexes(back)))
    assert all(same(tick, whole.ticks[tick.index]) for tick in back)
    if len(back) < COUNT:
        assert contents.damage


def test_a_repaired_log_is_whole_for_everybody(tmp_path: Path, whole: Whole) -> None:
    bad, mended = tmp_path / "bad.mcap", tmp_path / "mended.mcap"
    left, _ = read(bad, damaged_chunk(whole, middle(whole)))
    done = repair(bad, mended)
    assert len(done.damages) == 1
    back, contents = read(tmp_path / "again.mcap", mended.read_bytes())
    assert contents.damages == ()
    assert contents.progress.finished
    assert contents.config_text == "name = 'x'\n"
    assert all(map(same, back, left))
    with mended.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == done.kept


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"nothing of ours" * 10])
def test_what_holds_nothing_is_not_repaired(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordError, match=r"nothing in .* can be read"):
        repair(path, tmp_path / "out.mcap")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.mcap"], "nothing is left behind"


def test_a_log_is_not_repaired_into_itself(tmp_path: Path, whole: Whole) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(whole.data)
    with pytest.raises(RecordError, match="is the log itself"):
        repair(path, tmp_path / "." / "log.mcap")
    assert path.read_bytes() == whole.data


def test_a_folder_is_no_log(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="cannot be read: Is a directory"):
        list(read_records(tmp_path, Pass()))


def test_a_log_of_the_first_format_reads_as_ever() -> None:
    """Committed when the format was new: forty ticks of a walk on the virtual robot."""
    contents = LogContents()
    ticks = list(read_ticks(Path(__file__).parent / "logs" / "format_1.mcap", contents))
    assert contents.damages == ()
    assert indexes(ticks) == list(range(512, 552))
    assert contents.metadata["software"] == "bigant 0.1.0"
    assert "[legs]" in contents.config_text
    servos, (record,) = ticks[-1].inputs.servos, ticks[-1].inputs.forces
    assert servos is not None
    assert servos.position_ticks.tolist() == [2683, 1536, 2683, 2558, 1413, 2558]
    assert record.counts[0].tolist() == [-5928992, 388772, 9849735, 47785, 1914553, -48236]
    assert ticks[-1].forces.force_n[0] == pytest.approx([-5.928992, 0.388772, 9.849735])
    assert ticks[-1].joints.angle_rad[1] == pytest.approx(-0.78539816)
    assert ticks[-1].mode is Mode.WALK
    assert ticks[-1].contact.support.converged
    reckoned = ticks[-1].dead_reckoning
    assert reckoned.position_m == pytest.approx([1.7174297709e-3, 1.713325e-5], rel=1e-9)
    assert reckoned.yaw_rad == pytest.approx(-0.030527803590907)
    assert all(tick.estimate is None for tick in ticks), "the estimator came later"


def test_dead_reckoning_and_estimate_of_the_second_format_are_not_confused() -> None:
    """Its fields ``estimate`` and ``odometry`` were dead reckoning and the estimate."""
    contents = LogContents()
    ticks = list(read_ticks(Path(__file__).parent / "logs" / "format_2.mcap", contents))
    assert contents.damages == ()
    assert indexes(ticks) == list(range(62))
    servos, last = ticks[-1].inputs.servos, ticks[-1]
    assert servos is not None
    assert servos.position_ticks.tolist() == [2825, 1623, 2825, 2474, 1271, 2472]
    assert last.mode is Mode.WALK
    reckoned, estimate = last.dead_reckoning, last.estimate
    assert reckoned.position_m == pytest.approx([6.559878664779e-3, -1.292135217299e-4])
    assert reckoned.yaw_rad == pytest.approx(-0.029529677781586)
    assert estimate is not None
    assert estimate.position_m == pytest.approx([9.113805092770e-4, 1.500840874935e-4])
    assert estimate.yaw_rad == pytest.approx(-1.2525705652e-05)
    assert estimate.mu[:2] == pytest.approx([0.592872012435, 0.582317770425])
    assert np.diagonal(estimate.pose_covariance) == pytest.approx(
        [6.721204290657e-07, 3.935198045862e-07, 1.036407172298e-06]
    )
    assert estimate.health is Health.OK


def test_the_third_format_has_no_imu_and_no_gyro_bias() -> None:
    contents = LogContents()
    ticks = list(read_ticks(Path(__file__).parent / "logs" / "format_3.mcap", contents))
    assert contents.damages == ()
    assert indexes(ticks) == list(range(62))
    assert all(tick.inputs.imu == () for tick in ticks)
    last = ticks[-1]
    assert last.mode is Mode.WALK
    assert last.estimate is not None
    assert np.isnan([last.estimate.gyro_bias_rad_s, last.estimate.gyro_bias_sd]).all()
    assert last.estimate.health is Health.OK, "what comes behind it is read from its place"
    assert last.estimate.position_m == pytest.approx([9.2e-4, 1.1e-4], abs=2e-3)


def test_a_layout_that_nobody_knows_is_said_so(tmp_path: Path) -> None:
    """A log of a newer program: refused as a whole, not read as garbage."""
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "new.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        schema = writer.register_schema("bigant_msgs/msg/Tick", "ros2msg", b"int64 other\n")
        channel = writer.register_channel("/bigant/tick", "cdr", schema)
        writer.add_metadata("bigant", {"software": "bigant 99"})
        writer.add_message(channel, 1, b"\x00\x01\x00\x00" + bytes(8), 1)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(
        RecordError, match=r"layout that is not known here \(written by bigant 99\)"
    ):
        list(read_ticks(path))
