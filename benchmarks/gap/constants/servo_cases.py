"""A servo with a pendulum, of which it is known what was wrong: runs of its own simulator, with noise."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.gap.constants.cases import KnownCase, drawn, truths_of
from gap.check.cases import OUTSIDE, PAIR, SINGLE
from gap.interfaces import Cause, Drive
from gap.machines.servo_bench.simulator import servo_bench
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial

JOINTS = ("arm",)
NAMES = (
    "coulomb_friction",
    "viscous_friction",
    "play",
    "command_delay",
    "controller_gain",
    "payload",
)
KINDS = (SINGLE, SINGLE, PAIR, OUTSIDE)
HZ, FRAMES, RUNS, NOISE_RAD = 50.0, 500, 4, 0.001
COGGING_RAD, COGS = 0.004, 20.0  # what no effect is: the shaft is held at so many angles a turn
WANDER = 0.03  # of the controller's gain, from run to run


def servo_cases() -> Iterator[KnownCase]:
    """Yield all cases with healthy runs and without, always the same."""
    for referenced in (True, False):
        for at, kind in enumerate(KINDS):
            yield _case(kind, 2 * at + referenced, referenced=referenced)


def _case(kind: str, seed: int, *, referenced: bool) -> KnownCase:
    rng = np.random.default_rng([13, seed])
    simulator = servo_bench([servo_trial(MOTOR, np.zeros(FRAMES), hz=HZ)])
    catalogue = {one.name: one for one in simulator.effects}
    names = rng.choice(NAMES, {SINGLE: 1, PAIR: 2}.get(kind, 0), replace=False)
    effects = [catalogue[str(name)] for name in names]
    causes = [
        Cause(one.effect, JOINTS, one.values)
        for one in (drawn(e, JOINTS, kind, rng) for e in effects)
    ]
    cogging = COGGING_RAD if kind == OUTSIDE else 0.0
    trials = [_run(k, causes, cogging, rng) for k in range(RUNS)]
    references = [_run(k, [], 0.0, rng) for k in range(RUNS) if referenced]
    name = f"servo {kind} {seed}"
    truths = truths_of(effects, causes)
    return KnownCase(name, kind, truths, simulator, tuple(trials), tuple(references))


def _run(number: int, causes: Sequence[Cause], cogging: float, rng: np.random.Generator) -> Trial:
    time_s = np.arange(FRAMES) / HZ
    slow, fast = 2 * np.pi * (0.3 + 0.1 * number) * time_s, 2 * np.pi * 0.9 * time_s
    command = 0.6 * np.sin(slow + number) + 0.3 * np.sin(fast) + 0.2
    still = servo_trial(MOTOR, command, np.zeros(FRAMES), hz=HZ)
    loose = Cause("controller_gain", JOINTS, (1.0 + WANDER * rng.standard_normal(),))
    error = servo_bench([still]).predict(still, [*causes, loose], Drive.COMMAND)[:, 0]
    shaft = command + error
    shaft = shaft + cogging * np.sin(COGS * shaft) + rng.normal(0.0, NOISE_RAD, FRAMES)
    return servo_trial(MOTOR, command, shaft, hz=HZ)
