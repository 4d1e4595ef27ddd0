"""The index at the end of a log, read by us and by the library: the same, also where it is damaged."""

from collections.abc import Callable
from io import BytesIO

import numpy as np
import pytest
from mcap.reader import SeekingReader

from record.log.framing import file_index
from record.log.framing.file_index import ChunkPlace, FileIndex, read_index
from record.log.salvage import DAMAGE
from tests.record.test_log import write_log

FOOTER_BYTES = 29 + 8  # with the magic behind it


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("log") / "log.mcap"
    write_log(path, 40)
    return path.read_bytes()


def by_the_library(data: bytes) -> FileIndex | None:
    read = SeekingReader(BytesIO(data)).get_summary()
    if read is None:
        return None
    chunks = [
        ChunkPlace(
            one.chunk_start_offset,
            one.chunk_start_offset + one.chunk_length + one.message_index_length,
            frozenset(one.message_index_offsets),
        )
        for one in sorted(read.chunk_indexes, key=lambda one: one.chunk_start_offset)
    ]
    return FileIndex(tuple(read.schemas.values()), tuple(read.channels.values()), tuple(chunks))


def begin_of(data: bytes) -> int:
    footer = data[-FOOTER_BYTES:]
    return int.from_bytes(footer[9:17], "little")


def test_a_sound_index_is_read_without_the_library(
    log: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = by_the_library(log)
    monkeypatch.delattr(file_index, "SeekingReader")
    read = read_index(BytesIO(log))
    assert read == expected
    assert read is not None
    assert len(read.chunks) > 1
    assert len(read.channels) > 10


def outcome(read: Callable[[bytes], FileIndex | None], data: bytes) -> object:
    try:
        return read(data)
    except DAMAGE as error:
        return type(error)


@pytest.mark.parametrize("seed", range(4))
def test_damaged_it_is_what_the_library_makes_of_it(log: bytes, seed: int) -> None:
    random = np.random.default_rng(seed)
    begin = begin_of(log)
    readable = broken = 0
    for _ in range(60):
        data = bytearray(log)
        for _ in range(int(random.integers(1, 3))):
            data[int(random.integers(begin, len(data)))] ^= 1 << int(random.integers(8))
        if random.random() < 0.2:
            del data[int(random.integers(begin, len(data))) :]
        ours = outcome(lambda whole: read_index(BytesIO(whole)), bytes(data))
        theirs = outcome(by_the_library, bytes(data))
        assert ours == theirs
        readable += isinstance(theirs, FileIndex)
        broken += not isinstance(theirs, FileIndex)
    assert readable > 5
    assert broken > 5


def test_a_file_without_an_index_has_none(log: bytes) -> None:
    footer = bytearray(log[-FOOTER_BYTES:])
    footer[9:29] = bytes(20)
    data = log[: begin_of(log)] + bytes(footer)
    assert read_index(BytesIO(data)) is by_the_library(data) is None
    with pytest.raises(DAMAGE):
        read_index(BytesIO(b"none at all"))
