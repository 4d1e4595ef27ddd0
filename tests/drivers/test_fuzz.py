"""A short run of ``benchmarks/fuzz/frames.py``; the long one is written up in docs/reliability.md."""

import pytest

from benchmarks.fuzz import frames as fuzz


def test_mutated_servo_frames_break_no_promise() -> None:
    figures = fuzz.fuzz_servo_frames(5_000, seed=7)
    assert figures.accepted > 500  # the whole ones, unless damage before swallowed them
    assert figures.refused > 2_000


def test_mutated_datagrams_break_no_promise() -> None:
    figures = fuzz.fuzz_force_datagrams(3_000, seed=7)
    assert figures.accepted > 300
    assert figures.refused > 500


def test_a_wrong_crc_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.dynamixel.frames.crc16", lambda _: 0x1234)
    with pytest.raises(fuzz.FuzzError, match="seed 7"):
        fuzz.fuzz_servo_frames(100, seed=7)
