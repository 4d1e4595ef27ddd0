"""Shaft speeds whose integral is the way that the shafts went."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from model.motion.shaft_speed import AGREE_S, LONGEST_S, agreed, agreed_over

COUNT_RAD = 2 * np.pi / 4096


def turning(period_s: float, seconds: float = 4.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, angles and true speeds of two shafts that turn with a changing speed."""
    t_ns = np.round(np.arange(0.0, seconds, period_s) * 1e9).astype(np.int64)
    t_s = 1e-9 * t_ns[:, None]
    pace, sway = np.array([0.6, -1.5]), np.array([0.3, 0.2])
    angle = pace * t_s + sway * np.sin(2 * np.pi * 0.3 * t_s)
    rate = pace + sway * 2 * np.pi * 0.3 * np.cos(2 * np.pi * 0.3 * t_s)
    return t_ns, angle, rate


def way(t_ns: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The integral of speeds, as odometry takes it, (J,)."""
    dt_s = 1e-9 * np.diff(t_ns)[:, None]
    went: np.ndarray = (0.5 * (rate[:-1] + rate[1:]) * dt_s).sum(axis=0)
    return went


@given(
    period_s=st.sampled_from([0.015, 0.02, 0.03, 0.1]),
    share=st.floats(-0.3, 0.3),
    offset_rad_s=st.floats(-0.5, 0.5),
)
def test_the_angle_is_right_whatever_the_servo_says(
    period_s: float, share: float, offset_rad_s: float
) -> None:
    t_ns, angle, rate = turning(period_s)
    counted = np.round(angle / COUNT_RAD) * COUNT_RAD
    said = (1 + share) * rate + offset_rad_s
    corrected = agreed_over(t_ns, counted, said)
    late = slice(np.searchsorted(t_ns, 10 * AGREE_S * 1e9), None)  # once it is corrected
    went = angle[-1] - angle[late][0]
    # What the angle lags by while the wanted correction changes, and two counts.
    changing = 2 * abs(share) * AGREE_S
    assert np.all(np.abs(way(t_ns[late], corrected[late]) - went) < changing + 2 * COUNT_RAD)
    if abs(offset_rad_s) > 0.1 and abs(share) < 0.01:
        uncorrected = np.abs(way(t_ns[late], said[late]) - went)
        assert np.all(uncorrected > 10 * (changing + 2 * COUNT_RAD))


@given(period_s=st.sampled_from([0.005, 0.01, 0.013]), offset_rad_s=st.floats(-0.5, 0.5))
def test_a_fast_loop_takes_the_servos_own_speed(period_s: float, offset_rad_s: float) -> None:
    t_ns, angle, rate = turning(period_s, 1.0)
    said, memory = rate + offset_rad_s, None
    for now_ns, now, own in zip(t_ns.tolist(), angle, said, strict=True):
        memory, corrected = agreed(memory, now_ns, now, own)
        np.testing.assert_array_equal(corrected, own)
    np.testing.assert_array_equal(agreed_over(t_ns, angle, said), said)


def test_right_speeds_keep_their_value_but_for_a_count_of_the_encoder() -> None:
    t_ns, angle, rate = turning(0.02, 8.0)
    counted = np.round(angle / COUNT_RAD) * COUNT_RAD
    corrected = agreed_over(t_ns, counted, rate)
    # Each count enters with (1 - exp(-dt / AGREE_S))^2 / dt and is forgotten over AGREE_S.
    assert np.abs(corrected - rate).max() < COUNT_RAD / AGREE_S
    assert np.sqrt(((corrected - rate) ** 2).mean()) < 0.25 * COUNT_RAD / AGREE_S


def test_a_speed_read_in_the_lull_of_each_jump_is_corrected() -> None:
    """Goals come every 30 ms; the servo jumps for 20 ms, then slows down, and is read then."""
    fine_s, ticks = 0.001, 200
    pattern = np.r_[np.full(20, 0.9), np.full(10, 0.3)]
    speed = np.tile(pattern, ticks)
    angle = np.cumsum(speed) * fine_s
    read = np.arange(29, len(speed), 30)
    t_ns = ((read + 1) * fine_s * 1e9).astype(np.int64)
    corrected = agreed_over(t_ns, angle[read, None], speed[read, None])
    np.testing.assert_array_equal(speed[read], 0.3)  # every reading is short of the mean, 0.7
    np.testing.assert_allclose(corrected[30:], 0.7, atol=1e-3)


def test_a_missing_reading_is_missing_and_what_was_learned_is_kept() -> None:
    t_ns, angle, rate = turning(0.02, 8.0)
    said = rate + 0.1
    memory = None
    for i in range(200):
        memory, _ = agreed(memory, int(t_ns[i]), angle[i], said[i])
    lost = np.array([np.nan, angle[200, 1]])
    memory, gap = agreed(memory, int(t_ns[200]), lost, np.array([np.nan, said[200, 1]]))
    assert np.isnan(gap[0])
    np.testing.assert_allclose(gap[1], rate[200, 1], atol=2e-3)
    memory, back = agreed(memory, int(t_ns[201]), angle[201], said[201])
    np.testing.assert_allclose(back, rate[201], atol=2e-3)


def test_the_same_reading_twice_changes_nothing() -> None:
    t_ns, angle, rate = turning(0.02, 8.0)
    memory = None
    for i in range(200):
        memory, first = agreed(memory, int(t_ns[i]), angle[i], rate[i] + 0.1)
    again, second = agreed(memory, int(t_ns[199]), angle[199], rate[199] + 0.1)
    assert again is memory
    np.testing.assert_array_equal(first, second)


def test_after_a_gap_and_when_time_goes_back_it_starts_anew() -> None:
    t_ns, angle, rate = turning(0.02, 8.0)
    memory = None
    for i in range(200):
        memory, _ = agreed(memory, int(t_ns[i]), angle[i], rate[i] + 0.1)
    for later_ns in (int(LONGEST_S * 1e9) + 1, -1):
        anew, speed = agreed(memory, int(t_ns[199]) + later_ns, angle[199] + 3.0, rate[199])
        np.testing.assert_array_equal(speed, rate[199])
        np.testing.assert_array_equal(anew.error_rad_s, 0.0)


def test_an_angle_that_jumps_is_no_speed() -> None:
    """An encoder that is read a turn off, or a servo that is zeroed anew."""
    t_ns, angle, rate = turning(0.02, 8.0)
    angle = angle.copy()
    angle[75:, 0] += 1.0
    corrected = agreed_over(t_ns, angle, rate + 0.1)
    np.testing.assert_allclose(corrected[60:], rate[60:], atol=3e-3)
