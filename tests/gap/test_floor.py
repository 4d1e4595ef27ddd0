"""What is expected without a new cause, where no reference shows it."""

import numpy as np

from gap.diagnosis.study import like_others
from gap.interfaces import Channel
from gap.residuals.floor import make_floor
from gap.residuals.parts import whole_parts
from tests.gap.toy import CHANNELS, Toy, toy_trial


def test_a_sensor_that_drifts_is_no_noisier() -> None:
    (part,) = whole_parts(Toy(), [toy_trial()])
    noise = np.random.default_rng(4).normal(0, 0.1, part.observation.values.shape)
    drift = np.outer(part.observation.time_s, [0, 0, 0, 0.2, 0, 0, 0])
    steady = make_floor(CHANNELS, (), [(part, noise)]).sigma
    drifting = make_floor(CHANNELS, (), [(part, noise + drift)]).sigma
    np.testing.assert_allclose(drifting, steady, rtol=1e-3)
    assert (abs(steady - 0.08) < 0.01).all()  # of frames between which phases are interpolated


def test_a_channel_is_expected_to_be_no_worse_than_three_times_its_like() -> None:
    channels = [Channel("force", joint, "press", "N") for joint in "abcd"]
    channels += [Channel("speed", "", "move", "m/s")]
    channels += [Channel("angle", joint, "drive", "rad") for joint in "abc"]
    expected = np.array([1.0, 2.0, 2.0, 100.0, 50.0, 0.1, 0.1, 9.0])
    usual = like_others(channels, expected)
    # three of a name are too few to tell which of them is unlike the others
    np.testing.assert_array_equal(usual, [1.0, 2.0, 2.0, 6.0, 50.0, 0.1, 0.1, 9.0])
