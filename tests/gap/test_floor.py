"""What is expected without a new cause, where no reference shows it."""

import numpy as np

from gap.residuals.floor import make_floor
from gap.residuals.parts import whole_parts
from tests.gap.toy import CHANNELS, Toy, toy_trial


def test_a_sensor_that_drifts_is_no_noisier() -> None:
    (part,) = whole_parts(Toy(), [toy_trial()])
    noise = np.random.default_rng(4).normal(0, 0.1, part.observation.values.shape)
    drift = np.outer(part.observation.time_s, [0, 0, 0, 0.2, 0, 0, 0])
    steady = make_floor(CHANNELS, (), [(part, noise)])
    drifting = make_floor(CHANNELS, (), [(part, noise + drift)])
    np.testing.assert_allclose(drifting.sigma, steady.sigma, rtol=1e-9)
    np.testing.assert_allclose(drifting.dependence, steady.dependence, rtol=1e-2)
    assert (
        abs(steady.sigma - 0.08) < 0.01
    ).all()  # of frames between which phases are interpolated
