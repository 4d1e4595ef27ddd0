"""Diagnose all known cases with one constant at another value, in a process of its own.

Modules of the diagnosis take constants by value when they are imported; so the constant is set before any
of them is, and nothing in them has to know that they can be varied.
"""

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from benchmarks.gap.constants.changes import OF_PROBABILITIES, Change
from benchmarks.gap.constants.figures import JudgedCase
from gap import constants
from gap.constants import Constant
from model.errors import GapError


def as_they_are(campaigns: Sequence[Path] = (), cases: Sequence[Path] = ()) -> list[JudgedCase]:
    """Return the known cases, diagnosed here, or saved answers, judged again, or legged cases, diagnosed.

    Saved answers are those of ``campaigns``, legged cases those in the folders ``cases``.
    """
    if campaigns:
        answers = _module("saved_answers")  # made with constants as they were then
        return [answers.again(case) for case in answers.saved(campaigns)]
    known: list[JudgedCase] = (
        _module("legged_cases").diagnosed(cases) if cases else _module("answers").answered()
    )
    return known


def judged(
    change: Change, before: Sequence[JudgedCase], cases: Sequence[Path] = ()
) -> list[JudgedCase]:
    """Return every case with the answer to it; to be called in a fresh process.

    ``before`` are the cases as they are: what acts on probabilities alone is judged on their answers.
    ``cases`` are those of legged robots to diagnose; none for the small machines.
    """
    set_before_use(change)
    if change.name in OF_PROBABILITIES:
        again = _module("saved_answers").again
        answers = [again(case) for case in before]
    else:
        answers = as_they_are(cases=cases)
    check_used(change)
    return answers


def _module(name: str) -> ModuleType:
    """One that imports the diagnosis."""
    return importlib.import_module(f"benchmarks.gap.constants.{name}")


def set_before_use(change: Change) -> None:
    """Set a constant that no module has taken yet.

    Raises:
        GapError: One has.
    """
    if taken := users_of(change.name):
        raise GapError(f"{change.name} is in use by {', '.join(taken)}; set it in a fresh process")
    old: Constant = getattr(constants, change.name)
    setattr(constants, change.name, Constant(change.value, old.meaning, old.chosen))


def check_used(change: Change) -> None:
    """Make sure that all modules that have a constant have it at its new value.

    Raises:
        GapError: None has it, or one at another value.
    """
    users = users_of(change.name)
    wrong = [one for one in users if getattr(sys.modules[one], change.name) != change.value]
    if wrong or not users:
        words = ", ".join(wrong) or "no module"
        raise GapError(f"{change.name} = {change.value:g} did not reach the diagnosis: {words}")


def users_of(name: str) -> Sequence[str]:
    """Return the modules of the diagnosis that have taken a constant; none for no name."""
    return [
        module
        for module, held in list(sys.modules.items())
        if module.startswith("gap.")
        and not module.startswith(constants.__name__)  # where it is from
        and isinstance(getattr(held, name, None), Constant)
    ]
