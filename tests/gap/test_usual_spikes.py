"""Lone samples that healthy runs have as well are no fault to fix first."""

from dataclasses import replace

import numpy as np
import pytest

from gap.data.check import check_trial
from gap.data.usual_spikes import without_usual_spikes
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, DataFault
from record.trial.trial import Trial
from tests.gap.toy import Toy, toy_case, toy_references
from tests.gap.walks import walk


def fault(share: float | None, channel: str = "force", kind: str = "spikes") -> DataFault:
    return DataFault(kind, channel, "31 lone samples stand out", True, share)


@pytest.mark.parametrize(
    ("shares", "severe"),
    [
        ([0.008, 0.009, 0.007], False),
        ([0.005, 0.02, 0.0053], False),
        ([0.001, 0.007, 0.001, 0.0053], False),  # two of four walk with the gait that rattles
        ([0.001, 0.001, 0.009], True),
        ([0.009], False),  # all that is known
        ([None, None, None], True),
        ([], True),
    ],
)
def test_it_is_severe_only_where_references_have_far_less(
    shares: list[float | None], severe: bool
) -> None:
    references = [(fault(share),) if share else () for share in shares]
    (only,), *_ = without_usual_spikes([(fault(0.0103),)], references)
    assert only.severe == severe
    assert only.evidence.endswith("a third as many or more") != severe


def test_nothing_else_is_changed() -> None:
    references = [(fault(0.02),)] * 3
    others = (fault(0.02, "speed"), fault(0.02, kind="frozen"), fault(None))
    mild = replace(fault(0.02), severe=False)
    assert without_usual_spikes([others, (), (mild,)], references)[:3] == (others, (), (mild,))


@pytest.mark.parametrize(
    ("shares", "severe"),
    [
        ([0.0107, 0.0077, 0.0023, 0.0007], False),  # how the machine walks with one of two gaits
        ([0.0120, 0.0057, 0.0050, 0.0010], False),  # 36 lone samples, and 17 in another run like it
        ([0.0107, 0.0023, 0.0023, 0.0007], True),
        ([0.0107, None, None, None], True),
        ([0.0107], True),
    ],
)
def test_a_reference_is_judged_by_the_others(shares: list[float | None], severe: bool) -> None:
    references = [(fault(share),) if share else () for share in shares]
    (first,), *_ = without_usual_spikes([], references)
    assert first.severe == severe


def rattling(trial: Trial, count: int) -> Trial:
    """The same with lone samples in one force."""
    force = trial.force_n.copy()
    at = np.linspace(5, len(force) - 5, count).astype(int)
    force[at, 2, 1] += 60.0
    return replace(trial, force_n=force)


def test_a_walk_whose_feet_rattle_in_all_runs_has_no_severe_fault() -> None:
    trial = walk("tripod", 0.2, 12.0, noise_seed=3)
    many, few = round(0.012 * len(trial.time_s)) + 1, round(0.009 * len(trial.time_s))
    faults = check_trial(rattling(trial, many))
    (spikes,) = (one for one in faults if one.kind == "spikes")
    assert spikes.severe
    assert spikes.share == pytest.approx(many / len(trial.time_s))
    references = [check_trial(rattling(trial, few + more)) for more in range(3)]
    assert not any(one.severe for one in without_usual_spikes([faults], references)[0])
    clean = [check_trial(trial)] * 3
    assert without_usual_spikes([faults], clean)[0] == faults


class RattlingToy(Toy):
    """Says that every run has lone samples in its forces, more than are severe."""

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        return (fault(0.012),)


def test_a_diagnosis_asks_its_references() -> None:
    trials, references = toy_case([Cause("bias", ("a",), (0.9,))], 3), toy_references(3)
    d = diagnose(trials, RattlingToy(), references)
    assert len(d.data_faults) == len(trials) + len(references)
    assert not any(own.severe for one in d.data_faults for own in one.faults)
    assert diagnose(trials, RattlingToy()).severe_channels == ("force",)
