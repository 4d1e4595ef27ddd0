"""The legged chain: time of a prediction, and whether each effect's size can be found again.

The second table is a check of the code, not of the diagnosis: data and fit come from the same chain. An
effect whose largest trace is below the sensors' noise is called blind in these two walks.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from gap.interfaces import Cause, Drive, Effect, Scope
from gap.machines.legged.simulator import LeggedSimulator
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.walks import cause, machine, walk

LEG = "ML"
COULOMB = cause("coulomb_friction")
GAITS = (("tripod", 0.2), ("metachronal", 0.15))
# sizes that a builder would notice; effects with a partner that says where or how fast get it here
SIZES: dict[str, tuple[float, ...]] = {
    "servo_speed_limit": (1.5,),
    "ground_stiffness": (0.7,),
    "ground_step": (0.005, 0.05),
    "payload": (0.6, 0.05, -0.04),
    "stiction": (1.3, 0.006),
    "friction_patch": (0.7, 0.05),
}


# a limit above the fastest command leaves no trace to follow; others begin half way to their truth
BEGINNINGS: dict[str, tuple[float, ...]] = {"servo_speed_limit": (1.6,)}


def main() -> None:
    """Print both tables."""
    _times()
    _recovery()


def _times() -> None:
    trial = walk("metachronal", 0.2, 30.0, noise_seed=1)
    print(f"one prediction, {trial.time_s[-1]:.0f} s at 100 Hz, nothing remembered, one core:")
    cases = (
        ("viscous", ()),
        ("coulomb", (COULOMB,)),
        ("viscous, compliance", (cause("servo_compliance", 0.01),)),
        ("coulomb, compliance", (COULOMB, cause("servo_compliance", 0.01))),
        ("coulomb, flex", (COULOMB, cause("leg_flex", 3e-5, 3e-5))),
    )
    for name, causes in cases:
        for drive in Drive:
            took = _processor_ms(partial(_afresh, trial, causes, drive))
            print(f"  {name:<22} {drive.value:<9} {took:7.1f} ms")


def _processor_ms(action: Callable[[], object]) -> float:
    """Median time of one core over nine calls, whatever else runs on the machine [ms]."""
    action()
    samples = []
    for _ in range(9):
        began = time.process_time()
        action()
        samples.append(time.process_time() - began)
    return 1e3 * float(np.median(samples))


def _afresh(trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
    """Predict with a chain that remembers nothing; the trial's inputs are laid on the grid again too."""
    return LeggedSimulator(machine()).predict(trial, causes, drive)


def _recovery() -> None:
    simulator = LeggedSimulator(machine())
    trials = [walk(gait, hz, 14.0) for gait, hz in GAITS]
    noises = [simulator.observe(trial) for trial in trials]
    scales = [np.where(o.weight > 0, 1.0 / o.noise, 0.0) for o in noises]
    print("each effect, data from the chain under Coulomb's law, command drive, no noise:")
    print(
        f"  {'effect':<20} {'truth':>24} {'relative error':>15} {'trace/noise':>12} {'largest in':>12}"
    )
    for effect in simulator.effects:
        if effect.parameters:
            print("  " + _row(simulator, effect, trials, scales), flush=True)


def _row(
    simulator: LeggedSimulator, effect: Effect, trials: list[Trial], scales: list[FloatArray]
) -> str:
    legs = (LEG,) if Scope.JOINT in effect.scopes else ()
    neutral = np.array([p.neutral for p in effect.parameters])
    truth = np.array(SIZES.get(effect.name, neutral + [p.spread for p in effect.parameters]))

    def stacked(values: FloatArray) -> FloatArray:
        causes = (COULOMB, cause(effect.name, *values.tolist(), legs=legs))
        return np.concatenate([
            np.nan_to_num(scale * simulator.predict(trial, causes, Drive.COMMAND)).ravel()
            for trial, scale in zip(trials, scales, strict=True)
        ])  # fmt: skip

    target, base = stacked(truth), stacked(neutral)
    trace = target - base
    channel = int(np.argmax(np.sum(trace.reshape(-1, len(simulator.channels)) ** 2, axis=0)))
    began = time.perf_counter()
    spread = np.array([p.spread for p in effect.parameters])
    low, high = (np.array([getattr(p, n) for p in effect.parameters]) for n in ("lower", "upper"))
    start = np.clip(neutral + 0.5 * (truth - neutral), low, high)
    if effect.name in BEGINNINGS:
        start = np.array(BEGINNINGS[effect.name])

    def residual(x: FloatArray) -> FloatArray:
        return stacked(np.clip(x * spread, low, high)) - target

    found = least_squares(
        residual,
        start / spread,
        bounds=((low - 1e-12) / spread, (high + 1e-12) / spread),
        diff_step=np.full(len(spread), 1e-3),
        x_scale="jac",
    )
    error = np.abs(found.x * spread - truth) / np.maximum(np.abs(truth - neutral), 1e-12)
    worst = float(np.abs(error[np.abs(truth - neutral) > 0]).max(initial=0.0))
    size = float(np.sqrt(np.mean(trace**2)))
    where = simulator.channels[channel]
    text = ", ".join(f"{value:.3g}" for value in truth)
    blind = "  BLIND" if np.abs(trace).max() < 1.0 else ""
    took = time.perf_counter() - began
    return (
        f"{effect.name:<20} {text:>24} {worst:>15.1e} {size:>12.2f} {where.name + ' ' + where.joint:>14}"
        f"{blind}  ({took:.1f} s, {found.nfev} steps)"
    )


if __name__ == "__main__":
    main()
