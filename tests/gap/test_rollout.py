"""A simulator in one piece behind the same interface; here the chain plays the physics engine."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import Cause, Drive, Simulator
from gap.machines.mujoco.simulator import RolloutSimulator
from model.effects.catalogue import CATALOGUE
from model.errors import GapError
from record.trial.trial import Trial
from tests.gap.walks import cause, machine, simulator, walk

EFFECTS = CATALOGUE


def chain_rollout(trial: Trial, causes: tuple[Cause, ...]) -> Trial:
    return walk(trial.header.gait, trial.header.frequency_hz, float(trial.time_s[-1]), causes)


def test_it_answers_like_the_simulator_that_it_wraps() -> None:
    calls = []

    def counted(trial: Trial, causes: tuple[Cause, ...]) -> Trial:
        calls.append(causes)
        return chain_rollout(trial, causes)

    ours: Simulator = RolloutSimulator("engine", machine(), EFFECTS, counted)
    trial = walk("tripod", 0.2, 5.0, noise_seed=1)
    causes = (cause("coulomb_friction"), cause("com_offset", 0.01, 0.0))
    got = ours.predict(trial, causes, Drive.COMMAND)
    direct = simulator().predict(trial, causes, Drive.COMMAND)
    # samples between frames are averaged once more: corners differ, the rest does not
    assert np.median(np.abs(got - direct)) < 1e-4
    scale = np.std(direct, axis=0) + 1e-3
    assert np.sqrt(np.mean(((got - direct) / scale) ** 2)) < 0.1
    stages = [channel.stage for channel in ours.channels]
    fed = ours.predict(trial, causes, Drive.MEASURED)
    assert np.isfinite(fed[:, [s == "actuation" for s in stages]]).all()
    assert np.isnan(fed[:, [s != "actuation" for s in stages]]).all()
    assert len(calls) == 1  # remembered
    assert np.array_equal(ours.observe(trial).values, simulator().observe(trial).values)
    assert ours.check(trial) == simulator().check(trial)


def test_what_it_cannot_add_and_what_does_not_fit_is_refused() -> None:
    ours = RolloutSimulator("engine", machine(), EFFECTS[:1], chain_rollout)
    trial = walk("tripod", 0.2, 3.0)
    with pytest.raises(GapError, match="no effect of engine; known are command_delay"):
        ours.predict(trial, (cause("drag", 1.0),), Drive.COMMAND)
    short = RolloutSimulator(
        "engine", machine(), (), lambda t, c: replace(t.rows(t.time_s < 2.0), header=t.header)
    )
    with pytest.raises(GapError, match="answered with"):
        short.predict(trial, (), Drive.COMMAND)
