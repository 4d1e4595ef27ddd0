"""Cases of legged robots whose labels are open, diagnosed with the constants as they are here.

Channels of legged robots have constants that no small machine uses. A case takes half a minute, so there
are few. Importing this imports the diagnosis.
"""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.gap.constants.answers import checked
from benchmarks.gap.constants.figures import JudgedCase
from gap.diagnosis.diagnose import diagnose
from robot.campaign.answers import files_of, read_labels
from robot.campaign.case import read_case


def diagnosed(cases: Sequence[Path]) -> list[JudgedCase]:
    """Diagnose cases, each a folder ``CAMPAIGN/cases/NAME``, with all of their references."""
    return [_diagnosed(case.parents[1], case.name) for case in cases]


def _diagnosed(campaign: Path, name: str) -> JudgedCase:
    files = files_of(campaign, no_references=False)
    label = read_labels(campaign, None, files)[name]
    own = next(one for one in files if one.name == name)
    runs, simulator = read_case(own.trials, own.references)
    diagnosis = diagnose(runs.trials, simulator, runs.references)
    return checked(f"{campaign.name} {name}", label.kind, label.truths, diagnosis)
