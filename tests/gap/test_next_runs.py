"""The run that is proposed tells a pair apart better than the worst one, in data made by the chain."""

from collections.abc import Sequence

import numpy as np
import pytest

from gap.experiments.imitation import imitate
from gap.experiments.next_run import NextRun, next_runs
from gap.interfaces import Cause, Drive, Proposal, place_words
from gap.residuals.floor import Floor
from gap.residuals.part_error import most_dependent
from gap.search.candidates import Candidate
from record.trial.trial import Trial
from robot.config.robot_file import load_robot
from robot.gap_report.legged import proposer_of
from tests.gap.walks import cause, simulator, walk

TEXT = load_robot().text
EFFECTS = {effect.name: effect for effect in simulator().effects}
# Those of all proposals that a pair is judged on, so that the test stays short.
FEW = ("metachronal at 0.1 Hz, straight", "tripod at 0.2 Hz, straight", "middle")


def floor_of(trial: Trial) -> Floor:
    """Noise of the sensors alone, as a diagnosis without references would begin with."""
    noise = np.nanmean(simulator().observe(trial).noise, axis=0)
    count, lasting = len(noise), np.array([one.lasting for one in simulator().channels])
    dependence = np.where(lasting, most_dependent(len(simulator().observe(trial).noise)), 1.0)
    return Floor(
        "sensors", noise, dependence, (), np.zeros((0, 1, count)), np.zeros((1, count)),
        np.ones((1, count)), lasting, np.zeros(count),
    )  # fmt: skip


def proposals() -> Sequence[Proposal]:
    made = proposer_of(TEXT, None)[0].proposals()
    return [one for one in made if any(words in one.name for words in FEW)]


def left_after_fit(
    proposal: Proposal, of: tuple[Cause, ...], candidate: Candidate, floor: Floor
) -> float:
    """Energy that a rival leaves in a run made with the cause, however it is adjusted."""
    known = proposal.known
    goal = simulator().predict(proposal.trial, (*of, *known), Drive.COMMAND)
    best = imitate(simulator(), [proposal.trial], (*of, *known), 0, candidate, floor)
    error = (simulator().predict(proposal.trial, best, Drive.COMMAND) - goal) / floor.sigma
    return float(np.nansum(simulator().observe(proposal.trial).weight * error**2))


@pytest.mark.parametrize(
    ("there", "rival"),
    [
        (cause("command_delay", 0.04), "servo_lag"),
        (cause("leg_stiffness", 0.7, legs=("ML",)), "leg_length"),
        (cause("force_delay", 0.05), "force_lowpass"),
    ],
    ids=["delay_or_lag", "stiffness_or_length", "late_or_smoothed"],
)
def test_the_best_run_separates_better_than_the_worst(there: Cause, rival: str) -> None:
    made = walk("metachronal", 0.1, 20.0, (there,))
    floor = floor_of(made)
    candidate = Candidate(EFFECTS[rival], there.joints)
    sets = [(there,), imitate(simulator(), [made], (there,), 0, candidate, floor)]
    offered = {one.name: one for one in proposals()}
    ranked = next_runs(tuple(offered.values()), simulator(), sets, floor)
    assert ranked
    pair = (place_words(there.effect, there.joints), place_words(rival, there.joints))
    assert {one.pair for one in ranked} == {pair}
    by_name = {one.name: one.separation for one in ranked}
    best = max(offered.values(), key=lambda one: by_name.get(one.name, 0.0))
    worst = min(offered.values(), key=lambda one: by_name.get(one.name, 0.0))
    well = left_after_fit(best, (there,), candidate, floor)
    badly = left_after_fit(worst, (there,), candidate, floor)
    assert well > 3 * badly
    # what was promised to first order is what a full fit leaves, within a factor
    assert 0.3 < by_name[best.name] / well < 3.0


def test_delay_and_lag_are_told_by_a_faster_walk() -> None:
    there = (cause("command_delay", 0.04),)
    rival = (cause("servo_lag", 0.04),)
    floor = floor_of(walk("tripod", 0.1, 10.0))
    ranked = next_runs(proposals(), simulator(), [there, rival], floor)
    by_name = {one.name: one.separation for one in ranked}
    assert by_name["tripod at 0.2 Hz, straight"] > 10 * by_name["metachronal at 0.1 Hz, straight"]
    fast = next(one for one in ranked if one.name.startswith("tripod at 0.2"))
    assert fast.command == "bigant drive --gait tripod --frequency-hz 0.2 --cycles 4"


def test_proposals_keep_the_servos_limits_and_say_what_to_mind() -> None:
    proposer, note = proposer_of(TEXT, None)
    assert note == ""
    made = proposer.proposals()
    for one in made:
        name, frequency = one.trial.header.gait, one.trial.header.frequency_hz
        assert frequency <= proposer.limits_hz[name]
        speed = np.abs(np.diff(one.trial.command_rad, axis=0)).max() * 100
        assert speed < 4.0 * 1.01
    loaded = [one for one in made if one.known]
    assert len(loaded) == 4
    assert all("weigh it" in one.limits and "0.8 kg" in one.name for one in loaded)
    assert any("--steer 0.5" in one.command for one in made)


def test_a_robot_file_without_gaits_borrows_them_and_says_so() -> None:
    bare = TEXT[TEXT.index("[body]") : TEXT.index("[servo]")]
    proposer, note = proposer_of(bare, None)
    assert "config/bigant.toml" in note
    assert proposer.robot_text == bare


def test_proposals_are_of_all_gaits_of_the_robot_and_of_one_in_a_python_file() -> None:
    ripple = """
[gait.ripple]
kind = "phases"
frequency = 0.1
touchdown = [0.0, 0.3333, 0.6667, 0.5, 0.8333, 0.1667]
duty = 0.6667
stance_sweep = 2.0
"""
    proposer, _ = proposer_of(TEXT + ripple, None, "examples/own_gait.py")
    made = proposer.proposals()
    gaits = {one.trial.header.gait for one in made}
    assert gaits == {"tripod", "metachronal", "ripple", "own_gait"}
    commands = " ".join(one.command for one in made)
    assert "bigant drive --gait ripple --frequency-hz 0.1 --cycles 2" in commands
    assert "bigant drive --gait examples/own_gait.py --frequency-hz 0.12 --cycles 3" in commands


def test_a_robot_that_has_no_gait_borrows_them_too() -> None:
    still = TEXT[: TEXT.index("[gait.tripod]")]
    proposer, note = proposer_of(still, None)
    assert "config/bigant.toml" in note
    assert set(proposer.gaits) == {"tripod", "metachronal"}


def test_names_of_what_differs() -> None:
    delay, lag, law = (
        cause("command_delay", 0.04),
        cause("servo_lag", 0.04),
        cause("coulomb_friction"),
    )
    floor = floor_of(walk("tripod", 0.1, 10.0))
    one = [p for p in proposals() if p.name.startswith("tripod at 0.2")]
    ranked: tuple[NextRun, ...] = next_runs(one, simulator(), [(law, delay), (law, lag)], floor)
    assert ranked[0].pair == ("command_delay", "servo_lag")
