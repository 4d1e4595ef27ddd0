"""``--sim mujoco``: the MuJoCo robot under diagnosis, with few enough candidates to wait for.

A walk of half a minute takes seconds there, so the chain screens the catalogue first: the effects that
would explain most of what the chain leaves unexplained are the ones tried in MuJoCo.
"""

import sys
import time
from collections.abc import Callable, Sequence

from gap.delegate import TwoMachines
from gap.diagnosis.study import make_study
from gap.interfaces import Drive, Simulator
from gap.machines.legged.simulator import LeggedSimulator, legged_simulator
from gap.residuals.parts import split
from gap.search.candidates import candidates_of
from gap.search.screen import gains, make_signatures
from model.effects.machine import parse_machine
from model.errors import GapError
from record.trial.trial import Trial
from robot.console.progress import ProgressBar
from robot.virtual.twin_rollout import twin_catalogue, twin_simulator


def mujoco_simulator(
    trials: Sequence[Trial],
    references: Sequence[Trial],
    text: str,
    only: tuple[str, ...],
    screen: int,
    jobs: int,
) -> Simulator:
    """Return the MuJoCo robot as a simulator, and say on stderr what it will cost.

    Args:
        trials: Runs to be diagnosed.
        references: Healthy runs; they keep the robot file beside them.
        text: Robot file of the trials.
        only: Effects to try; screened by the chain where there are none.
        screen: How many effects pass the screen.
        jobs: Processes that will walk.

    Raises:
        GapError: The robot file cannot be used, or an effect is not the MuJoCo robot's.
    """
    chosen = only or _screened(trials, references, text, screen)
    own = twin_simulator(text, chosen)
    simulator: Simulator = own
    other = references[0].header.robot_text if references else text
    if other != text:
        simulator = TwoMachines(own, twin_simulator(other, chosen), tuple(references))
    print(f"MuJoCo: effects tried: {', '.join(chosen)}", file=sys.stderr)
    print(_cost_words(simulator, trials, references, jobs), file=sys.stderr)
    return simulator


def _cost_words(
    simulator: Simulator, trials: Sequence[Trial], references: Sequence[Trial], jobs: int
) -> str:
    """What looking at every candidate once will take, from one walk on this computer now."""
    began_s = time.perf_counter()
    simulator.predict(trials[0], (), Drive.COMMAND)  # remembered
    spent_s = time.perf_counter() - began_s
    fitted, _ = split(simulator, trials)
    numbers = sum(max(1, len(one.effect.parameters)) for one in candidates_of(simulator))
    walks = len(trials) + len(references) + numbers * len(fitted)
    return (
        f"MuJoCo: {walks} walks of {spent_s:.1f} s each before the first fit, about "
        f"{walks * spent_s / jobs / 60:.1f} min on {jobs} process(es), and some more for the fits"
    )


def _screened(
    trials: Sequence[Trial], references: Sequence[Trial], text: str, count: int
) -> tuple[str, ...]:
    """Names of the effects with which the chain would gain most, of those that MuJoCo has."""
    known = {effect.name for effect in twin_catalogue()}
    with ProgressBar("screening by the chain") as bar:
        order = _by_gain(trials, references, text, bar.show)
    names = [name for name in dict.fromkeys(order) if name in known][:count]
    if not names:
        raise GapError("the chain finds no effect worth trying; name some with --effects-only")
    return tuple(names)


def _by_gain(
    trials: Sequence[Trial],
    references: Sequence[Trial],
    text: str,
    progress: Callable[[float], None],
) -> list[str]:
    chain: Simulator = LeggedSimulator(parse_machine(text))
    if references and references[0].header.robot_text != text:
        chain = TwoMachines(chain, legged_simulator(references[0]), tuple(references))
    evidence = make_study(trials, chain, references).evidence(Drive.MEASURED)
    signatures = make_signatures(evidence, candidates_of(chain), (), progress)
    found = gains(signatures, evidence.base, evidence.weights(evidence.base))
    return [one.signature.candidate.effect.name for one in found if one.nats > 0]
