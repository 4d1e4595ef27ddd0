"""Trials for the diagnosis, from trial tables or logs, and the simulator that their machine calls for."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from gap.effect_file import UserEffect, read_effects
from gap.interfaces import Simulator
from model.errors import GapError
from record.export import export_trial
from record.reader import LogContents
from record.trial import Trial, read_trial
from record.trial_toml import LEGGED, SERVO_BENCH


def read_trials(paths: Sequence[Path]) -> tuple[Trial, ...]:
    """Read trials: .parquet, .csv, NAME.toml, or a log (.mcap).

    Raises:
        RecordError: A file cannot be read.
        GapError: They are of different machines.
    """
    trials = tuple(_read(path) for path in paths)
    for path, trial in zip(paths, trials, strict=True):
        first = trials[0].header
        if (trial.header.kind, trial.header.joints) != (first.kind, first.joints):
            raise GapError(
                f"{path} is of another machine than {paths[0]}: {trial.header.kind} with "
                f"{', '.join(trial.header.joints) or 'no joints'}; diagnose one machine at a time"
            )
    return trials


def _read(path: Path) -> Trial:
    if path.suffix != ".mcap":
        return read_trial(path)
    with TemporaryDirectory() as folder:
        out = Path(folder) / "trial.parquet"
        export_trial(path, out, LogContents())
        return read_trial(out)


def simulator_for(trials: Sequence[Trial], effects: Path | None) -> Simulator:
    """Return the simulator of the machine that the trials name.

    Args:
        trials: Trials of one machine.
        effects: A file of users' effects; only the legged simulator takes one.

    Raises:
        GapError: The machine's file or the file of effects cannot be used.
    """
    kind = trials[0].header.kind
    if kind == LEGGED:
        from gap.legged import legged_simulator
        from gap.legged_catalogue import CATALOGUE, STAGES

        added: tuple[UserEffect, ...] = ()
        if effects is not None:
            added = read_effects(effects, STAGES, tuple(entry.effect.name for entry in CATALOGUE))
        return legged_simulator(trials[0], added)
    if effects is not None:
        raise GapError(f"--effects is for legged robots; the trials are of kind {kind}")
    if kind == SERVO_BENCH:
        from gap.servo_bench import servo_bench

        return servo_bench(trials)
    from gap.sliding_body import sliding_body

    return sliding_body(trials)
