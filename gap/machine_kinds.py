"""Kinds of machines that can be diagnosed: plug-ins of the entry point group ``bigant.machines``.

A kind is known by the name of its entry point, which is what ``kind`` says in a machine's file. The name
refers to a ``MachineKind``, or only a function that makes a ``Simulator`` of trials. The machines that
come with the program are registered in the same group and in no other way; a machine that is not
installed is named as ``FILE.py:make``.
"""

import runpy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from gap.delegate import MachineKey, MachineOfEach, machine_key
from gap.interfaces import Cause, Effect, Proposal, Simulator
from model.errors import BigantError, GapError
from record.trial.trial import Trial

GROUP = "bigant.machines"
NO_APPLY = "has no way to write a cause into its file; put the numbers there by hand"
NO_PROPOSALS = (
    "does not say which runs it could make; vary its load, its speed and its motion by hand"
)
MEMBERS = (
    "name",
    "stages",
    "joints",
    "bodies",
    "effects",
    "channels",
    "observe",
    "predict",
    "check",
)

Make = Callable[[Sequence[Trial]], Simulator]
# Text of the machine's file, causes and the catalogue that they are of; returns the corrected text.
Apply = Callable[[str, Sequence[Cause], Sequence[Effect]], str]
# Causes and the catalogue that they are of; returns the effects that ``Apply`` cannot write.
Left = Callable[[Sequence[Cause], Sequence[Effect]], Sequence[str]]
# The runs that a machine could make, given those that were made.
Propose = Callable[[Sequence[Trial]], Sequence[Proposal]]


@dataclass(frozen=True, slots=True)
class MachineKind:
    """What a name of ``bigant.machines`` refers to.

    Attributes:
        make: Makes the simulator of trials that all name one machine's file, with the same constants of the
            log (``TrialHeader.constants``) and the same drive. Trials of other files get their own.
        apply: Writes causes into the text of a machine's file; None where it cannot.
        left: Names the effects that ``apply`` leaves out, because they are not of the machine's file; None
            where it writes all.
        propose: Says which runs could be made next; None where it cannot.
        with_effects: Returns the kind with effects of a user's file; None where it takes none.
        no_apply: Why there is no ``apply``, behind "a machine of kind NAME".
        no_propose: Why there is no ``propose``, in the same way.
        name: The name it is registered by; filled in when it is looked up.
    """

    make: Make
    apply: Apply | None = None
    left: Left | None = None
    propose: Propose | None = None
    with_effects: "Callable[[Path], MachineKind] | None" = None
    no_apply: str = NO_APPLY
    no_propose: str = NO_PROPOSALS
    name: str = ""


def machine_kinds() -> tuple[str, ...]:
    """Return the names of all kinds that are registered."""
    return tuple(sorted(_registered()))


@cache
def _registered() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


@cache
def kind_named(name: str) -> MachineKind:
    """Return the kind of machine that is registered by a name.

    Raises:
        GapError: None is, or it cannot be loaded.
    """
    known = _registered()
    if not known:
        raise GapError(
            f"no kind of machine is registered ({GROUP} is empty): install the package again (make install)"
        )
    if name not in known:
        raise GapError(
            f"no kind of machine is called {name!r}; there are {', '.join(machine_kinds())}: "
            "correct kind in the machine's file, install the package that has it, or name it: "
            "--machine FILE.py:make"
        )
    try:
        loaded = known[name].load()
    except Exception as error:  # whatever a plug-in raises is a mistake in it
        raise GapError(
            f"the machine {name!r} ({known[name].value}) cannot be loaded: {_words(error)}; fix or "
            "uninstall the package that registers it"
        ) from error
    return _kind(loaded, name, known[name].value)


def kind_of_file(text: str) -> MachineKind:
    """Return the kind of machine that ``FILE.py:NAME`` makes; the file is run as Python.

    Raises:
        GapError: There is no such file, it cannot be run, or it has nothing of that name.
    """
    file, _, name = text.rpartition(":")
    if not file.endswith(".py"):
        raise GapError(f"--machine {text}: name the function behind the file, as in FILE.py:make")
    path = Path(file)
    if not path.is_file():
        raise GapError(f"there is no file {path}; --machine takes FILE.py:make")
    try:
        names = runpy.run_path(str(path))
    except Exception as error:  # whatever a user's file raises is a mistake in it
        raise GapError(f"{path} cannot be run: {_words(error)}; fix it") from error
    if name not in names:
        known = ", ".join(sorted(one for one, value in names.items() if _own(one, value)))
        raise GapError(
            f"{path} has no {name or 'name behind the colon'}; it needs a function {name or 'make'}"
            f"(trials) that returns the machine{f'; it has {known}' if known else ''}"
        )
    return _kind(names[name], path.stem, text)


def _own(name: str, value: object) -> bool:
    return (
        callable(value)
        and not name.startswith("_")
        and getattr(value, "__module__", "") == "<run_path>"
    )


def _kind(loaded: object, name: str, where: str) -> MachineKind:
    if isinstance(loaded, MachineKind):
        kind = loaded
    elif callable(loaded):
        kind = MachineKind(loaded)
    else:
        raise GapError(f"{where} is no function and no MachineKind, but {type(loaded).__name__}")
    return replace(kind, name=name, make=_Checked(kind.make, where))


@dataclass(frozen=True, slots=True)
class _Checked:
    """Makes a machine and makes sure that it is one; whatever else it raises is a mistake in it."""

    make: Make
    where: str

    def __call__(self, trials: Sequence[Trial]) -> Simulator:
        try:
            made = self.make(trials)
        except BigantError:
            raise
        except Exception as error:
            raise GapError(f"{self.where} raises {_words(error)}; fix it") from error
        missing = [name for name in MEMBERS if not hasattr(made, name)]
        if missing:
            raise GapError(
                f"{self.where} makes a {type(made).__name__} without {', '.join(missing)}; a machine needs "
                "all of gap.interfaces.Simulator"
            )
        return made


def _words(error: Exception) -> str:
    text = str(error).strip().splitlines()
    return f"{type(error).__name__}: {text[0]}" if text else type(error).__name__


def simulator_of(kind: MachineKind, trials: Sequence[Trial]) -> Simulator:
    """Return the simulator of trials of one kind of machine, each with its own machine's file.

    Raises:
        GapError: A machine cannot be made, has other joints than its trials, or differs from the others in
            what may not differ.
    """
    groups: dict[MachineKey, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(machine_key(trial.header), []).append(trial)
    machines = []
    for key, own in groups.items():
        made = kind.make(own)
        _refuse_other_joints(made, own[0])
        machines.append((key, own[0].header.robot_file or "the machine without a file", made))
    return machines[0][2] if len(machines) == 1 else MachineOfEach(machines)


def _refuse_other_joints(simulator: Simulator, trial: Trial) -> None:
    missing = [joint for joint in simulator.joints if joint not in trial.joints]
    if missing:
        machine = trial.header.robot_file or f"the {simulator.name}"
        ours, theirs = ", ".join(simulator.joints), ", ".join(trial.joints) or "none"
        raise GapError(
            f"{machine} has joints {ours}, the log has {theirs}: give the file of the "
            "robot that was logged, or map its columns to these joints (bigant import --map)"
        )
