"""``--sim mujoco``: the MuJoCo robot under diagnosis, with few enough candidates to wait for.

A walk of half a minute takes seconds there, so the chain screens the catalogue first: the effects that
would explain most of what the chain leaves unexplained are the ones tried in MuJoCo.
"""

import sys
import time

from gap.interfaces import Drive, Simulator
from gap.residuals.parts import split
from gap.search.candidates import candidates_of
from gap.search.screen import gains, make_signatures
from model.errors import GapError
from robot.console.progress import ProgressBar
from robot.gap_report.study import study_of
from robot.gap_report.trials import Runs
from robot.virtual.twin_rollout import twin_catalogue, twin_simulator


def mujoco_simulator(runs: Runs, only: tuple[str, ...], screen: int, jobs: int) -> Simulator:
    """Return the MuJoCo robot as a simulator, and say on stderr what it will cost with so many ``jobs``.

    It tries the effects of ``only``; where there are none, the chain lets ``screen`` of them through.

    Raises:
        GapError: The robot file cannot be used, or an effect is not the MuJoCo robot's.
    """
    chosen = only or _screened(runs, screen)
    simulator = runs.made_by(lambda own: twin_simulator(own[0].header.robot_text, chosen))
    print(f"MuJoCo: effects tried: {', '.join(chosen)}", file=sys.stderr)
    print(_cost_words(simulator, runs, jobs), file=sys.stderr)
    return simulator


def _cost_words(simulator: Simulator, runs: Runs, jobs: int) -> str:
    """What looking at every candidate once will take, from one walk on this computer now."""
    began_s = time.perf_counter()
    simulator.predict(runs.trials[0], (), Drive.COMMAND)  # remembered
    spent_s = time.perf_counter() - began_s
    fitted, _ = split(simulator, runs.trials, runs.hold_out)
    numbers = sum(max(1, len(one.effect.parameters)) for one in candidates_of(simulator))
    walks = len(runs.trials) + len(runs.references) + numbers * len(fitted)
    return (
        f"MuJoCo: {walks} walks of {spent_s:.1f} s each before the first fit, about "
        f"{walks * spent_s / jobs / 60:.1f} min on {jobs} process(es), and some more for the fits"
    )


def _screened(runs: Runs, count: int) -> tuple[str, ...]:
    """Names of the effects with which the chain would gain most, of those that MuJoCo has."""
    chain = runs.simulator()
    with ProgressBar("screening by the chain") as bar:
        study = study_of(runs, chain)
        evidence = study.evidence(Drive.MEASURED)
        candidates = candidates_of(chain, study.predictor.standing)
        signatures = make_signatures(evidence, candidates, (), bar.show)
        ranked = gains(signatures, evidence.base, evidence.weights(evidence.base))
    known = {effect.name for effect in twin_catalogue()}
    order = [one.signature.candidate.effect.name for one in ranked if one.nats > 0]
    names = [name for name in dict.fromkeys(order) if name in known][:count]
    if not names:
        raise GapError("the chain finds no effect worth trying; name some with --effects-only")
    return tuple(names)
