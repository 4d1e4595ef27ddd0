"""Real logs that no one here made, where the folder of data sets is given by ``BIGANT_SHARED_DATA``."""

import os
from pathlib import Path

import pytest

from benchmarks.real_machines import COUNT_RAD, arm_trials, cube_trials, rig_trial
from gap.diagnosis import diagnose
from gap.findings import Verdict
from gap.servo_bench import servo_bench
from gap.sliding_body import sliding_body

FOLDER = os.environ.get("BIGANT_SHARED_DATA", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="BIGANT_SHARED_DATA names no folder")


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["Rotation", "Elbow"])
def test_an_arm_joint_is_explained_by_more_than_a_delay(joint: str) -> None:
    trials = arm_trials(Path(FOLDER), joint)
    d = diagnose(trials, servo_bench(trials))
    assert d.verdict in {Verdict.EXPLAINED, Verdict.AMBIGUOUS}
    assert "play" in {cause.effect for cause in d.causes}
    (shaft,) = d.far.channels
    assert shaft.after < 0.3 * shaft.before
    kinds = {(f.kind, f.channel) for one in d.data_faults for f in one.faults}
    assert ("magnitude_only", f"torque_{joint}_nm") in kinds


def test_the_backlash_of_the_rig_is_the_published_one() -> None:
    trial = rig_trial(Path(FOLDER))
    d = diagnose([trial], servo_bench([trial]))
    assert d.causes[0].effect == "backlash"
    assert d.causes[0].values[0].value / COUNT_RAD == pytest.approx(14.78, abs=1.0)


@pytest.mark.slow
def test_the_cube_slides_by_coulombs_law() -> None:
    trials = cube_trials(Path(FOLDER))
    d = diagnose(trials, sliding_body(trials))
    assert d.causes[0].effect == "coulomb_friction"
    slowing = next(c for c in d.far.channels if c.channel == "deceleration")
    assert slowing.after < 0.4 * slowing.before
