"""Diagnose all known cases with one constant at another value, in a process of its own.

Modules of the diagnosis take constants by value when they are imported; so the constant is set before any
of them is, and nothing in them has to know that they can be varied.
"""

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.gap_constants.changes import UNCHANGED, Change
from benchmarks.gap_constants.figures import JudgedCase
from gap import constants
from gap.constants import Constant
from model.errors import GapError


def judged(change: Change, campaigns: Sequence[Path] = ()) -> list[JudgedCase]:
    """Return every case with the answer to it; to be called in a fresh process.

    Without campaigns, whose saved answers are judged again, these are the known cases.
    """
    set_before_use(change)
    name = "saved_answers" if campaigns else "answers"
    answers = importlib.import_module(f"benchmarks.gap_constants.{name}")
    check_used(change)
    cases: list[JudgedCase] = answers.answered(campaigns) if campaigns else answers.answered()
    return cases


def set_before_use(change: Change) -> None:
    """Set a constant that no module has taken yet.

    Raises:
        GapError: One has.
    """
    if taken := users_of(change.name):
        raise GapError(f"{change.name} is in use by {', '.join(taken)}; set it in a fresh process")
    if change == UNCHANGED:
        return
    old: Constant = getattr(constants, change.name)
    setattr(constants, change.name, Constant(change.value, old.meaning, old.chosen))


def check_used(change: Change) -> None:
    """Make sure that all modules that have a constant have it at its new value.

    Raises:
        GapError: None has it, or one at another value.
    """
    if change == UNCHANGED:
        return
    users = users_of(change.name)
    wrong = [one for one in users if getattr(sys.modules[one], change.name) != change.value]
    if wrong or not users:
        words = ", ".join(wrong) or "no module"
        raise GapError(f"{change.name} = {change.value:g} did not reach the diagnosis: {words}")


def users_of(name: str) -> Sequence[str]:
    """Return the modules of the diagnosis that have a constant; none for no name."""
    return [
        module
        for module, held in list(sys.modules.items())
        if module.startswith("gap.")
        and held is not constants
        and isinstance(getattr(held, name, None), Constant)
    ]
