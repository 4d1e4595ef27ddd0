"""What is expected without a new cause, where no reference shows it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.residuals.floor import make_floor, with_starting, without_drift
from gap.residuals.part_error import PartError, phase_basis
from gap.residuals.parts import TrialPart, whole_parts
from gap.residuals.whitening import make_whitener
from model.values.arrays import FloatArray
from tests.gap.toy import CHANNELS, Toy, toy_trial


def part_of(cycles: float) -> TrialPart:
    """A part of so many cycles."""
    (part,) = whole_parts(Toy(), [toy_trial()])
    cycle = np.linspace(0.3, 0.3 + cycles, part.frames)
    return replace(part, observation=replace(part.observation, cycle=cycle))


def test_a_sensor_that_drifts_is_no_noisier() -> None:
    (part,) = whole_parts(Toy(), [toy_trial()])
    noise = np.random.default_rng(4).normal(0, 0.1, part.observation.values.shape)
    drift = np.outer(part.observation.time_s, [0, 0, 0, 0.2, 0, 0, 0])
    steady = make_floor(CHANNELS, (), [PartError(part, noise)])
    drifting = make_floor(CHANNELS, (), [PartError(part, noise + drift)])
    np.testing.assert_allclose(drifting.sigma, steady.sigma, rtol=1e-9)
    np.testing.assert_allclose(drifting.dependence, steady.dependence, rtol=1e-2)
    assert (
        abs(steady.sigma - 0.08) < 0.01
    ).all()  # of frames between which phases are interpolated


@pytest.mark.parametrize("cycles", [2.0, 2.3, 3.5, 7.0])
def test_an_error_that_only_repeats_itself_keeps_all_of_it(cycles: float) -> None:
    """Over whole cycles and parts of them: the error of a servo that lags is one of these."""
    part = part_of(cycles)
    phase = 2 * np.pi * part.observation.cycle[:, None]
    rng = np.random.default_rng(7)
    error = np.full((part.frames, 7), rng.normal())
    for k in range(1, 6):
        error += rng.normal(size=7) * np.sin(k * phase + rng.normal(size=7))
    np.testing.assert_allclose(without_drift(part, error), error, atol=1e-9)


def test_gaps_in_a_channel_stay_gaps() -> None:
    part = part_of(3.0)
    error = np.outer(part.observation.time_s, np.ones(7))
    error[40:60, 2] = error[:, 5] = np.nan
    steady = without_drift(part, error)
    np.testing.assert_array_equal(np.isnan(steady), np.isnan(error))
    kept = np.delete(steady, 5, axis=1)
    mean = np.nanmean(np.delete(error, 5, axis=1), axis=0)
    np.testing.assert_allclose(kept, np.where(np.isnan(kept), np.nan, mean), atol=1e-9)


def test_of_less_than_two_cycles_nothing_is_taken() -> None:
    part = part_of(1.9)
    error = np.outer(part.observation.time_s, np.ones(7))
    assert without_drift(part, error) is error


def test_what_lasts_is_expected_alike_at_all_frequencies_and_has_no_phase() -> None:
    """Two gaits at two frequencies, an error that only the gait decides, and noise in each window."""
    channels = tuple(replace(one, lasting=one.name == "speed") for one in CHANNELS)
    rng = np.random.default_rng(5)
    errors = []
    for gait, hz, mean in (("a", 0.1, 0.4), ("a", 0.2, 0.42), ("b", 0.1, -0.3), ("b", 0.2, -0.28)):
        part = replace(part_of(4.0), gait=gait, frequency_hz=hz)
        in_windows = mean + 0.02 * rng.normal(size=4)
        window = np.minimum((part.observation.cycle - 0.3).astype(int), 3)
        errors.append(PartError(part, np.tile(in_windows[window][:, None], (1, 7))))
    floor = make_floor(channels, errors[1:], ())
    frames = errors[0].part.frames
    assert floor.dependence[-1] == frames / 8
    unseen, signal = (floor.expect(errors[0].part.condition).mean[:, at] for at in (-1, 0))
    assert unseen[0] == pytest.approx(0.42, abs=0.05), "as at the other frequency"
    assert not unseen[1:].any()
    assert abs(signal[0] - 0.42) > 0.1, "of a signal, another frequency says less"
    assert signal[1:].any()


def test_misfit_scatter_and_noise_are_told_apart() -> None:
    """A misfit that all runs share is expected nearly whole, one that each has another of is not.

    High harmonics hold noise alone; how it scatters says nothing of the low ones.
    """
    rng = np.random.default_rng(11)
    part = replace(part_of(6.0), gait="a", frequency_hz=0.1)
    phase = 2 * np.pi * part.observation.cycle[:, None]
    count = len(CHANNELS)

    def runs(shared: float, own: float) -> list[PartError]:
        return [
            PartError(
                part,
                (shared + own * rng.normal(size=count)) * np.sqrt(2) * np.cos(phase)
                + rng.normal(0.0, 0.05, (part.frames, count)),
            )
            for _ in range(5)
        ]

    alike = make_floor(CHANNELS, runs(0.5, 0.0), ()).expect(part.condition)
    apart = make_floor(CHANNELS, runs(0.0, 0.5), ()).expect(part.condition)
    assert alike.mean[1] == pytest.approx(np.full(count, 0.5), rel=0.05)
    assert np.sqrt(alike.variance[1]).max() < 0.06
    assert np.sqrt(apart.variance[1].mean()) == pytest.approx(0.5, rel=0.6)
    # what is noise is expected to be next to nothing, and no more uncertain than noise
    for high in (alike, apart):
        assert np.abs(high.mean[15]).max() < 0.02, "the cosine of harmonic 8"
        assert np.sqrt(high.variance[15]).max() < 0.03


def test_forces_that_feet_trap_are_not_known_however_well_healthy_runs_agree() -> None:
    """A machine that has changed holds others, by as much as the simulator has wrong of them."""
    rng = np.random.default_rng(13)
    part = replace(part_of(6.0), gait="a", frequency_hz=0.1)
    phase = 2 * np.pi * part.observation.cycle[:, None]
    count = len(CHANNELS)
    noise = [rng.normal(0.0, 0.05, (part.frames, count)) for _ in range(4)]
    agreeing = [PartError(part, 0.5 * np.sqrt(2) * np.cos(phase) + one) for one in noise]
    channels = tuple(replace(one, trapped=one.name == "force") for one in CHANNELS)
    expected = make_floor(channels, agreeing, ()).expect(part.condition)
    trapped = np.array([one.trapped for one in channels])
    sd = np.sqrt(expected.variance[1])
    assert sd[~trapped].max() < 0.1
    assert sd[trapped].min() > 0.25
    np.testing.assert_allclose(expected.mean[1], 0.5, rtol=0.3)


def test_a_machine_that_starts_is_noisier_for_a_moment_and_not_for_the_whole_run() -> None:
    """Shafts leave five times their noise in the first half second: it is known there, and only there."""
    rng = np.random.default_rng(12)
    part = replace(part_of(6.0), gait="a", frequency_hz=0.1)
    since_s = part.observation.time_s - part.observation.time_s[0]
    starts = (since_s < 0.5)[:, None] & np.array([one.name == "angle" for one in CHANNELS])
    noise = np.where(starts, 5.0, 1.0)
    runs = [PartError(part, noise * rng.normal(size=noise.shape)) for _ in range(4)]

    def sigma(known: Sequence[PartError]) -> FloatArray:
        return make_floor(CHANNELS, known, ()).sigma

    known = with_starting(CHANNELS, runs)
    assert known[0].starting is not None
    np.testing.assert_allclose(known[0].starting.at(part), noise, rtol=0.3)
    assert (sigma(runs)[:3] > 1.1).all()
    np.testing.assert_allclose(sigma(known), 1.0, rtol=0.1)
    floor = make_floor(CHANNELS, known, ())
    whitener = make_whitener(part, floor, np.zeros(noise.shape))
    np.testing.assert_allclose(whitener.gain[0] / whitener.gain[-1], 1 / noise[0], rtol=0.3)
    later = replace(part, first=100, last=100 + part.frames)
    assert (make_whitener(later, floor, np.zeros(noise.shape)).gain == whitener.gain[-1]).all()


@given(st.integers(8, 400), st.floats(0.3, 40.0), st.floats(0.0, 1.0))
def test_harmonics_are_as_many_as_the_frames_tell_apart(
    frames: int, turned: float, begin: float
) -> None:
    """Of a run of two cycles or more: else those of a fast gait would explain each other's errors."""
    part = part_of(3.0)
    o, cycle = part.observation, np.linspace(begin, begin + turned, frames)
    rows = np.zeros(frames, dtype=np.int64)
    cut = replace(
        o, time_s=o.time_s[rows], cycle=cycle, values=o.values[rows], noise=o.noise[rows],
        weight=o.weight[rows],
    )  # fmt: skip
    basis = phase_basis(replace(part, first=0, last=frames, observation=cut))
    assert 1 <= basis.shape[1] <= min(frames, 73)
    if turned >= 2.0:
        assert np.linalg.cond(basis) < 3.0
