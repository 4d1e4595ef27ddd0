"""Runs on disk: made as foreign tables, and brought in by ``bigant import`` as a user would."""

from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.gap.apart.cases import PERIODS_S, PlannedRun
from benchmarks.gap.apart.robot import described_robot
from benchmarks.gap.apart.run import simulated_run
from benchmarks.gap.apart.table import ROBOT_NAME, map_text, robot_file_text, write_table
from record.earlier_file import earlier_files
from robot.gap_report.imports import imported
from robot.requests.recorded import ImportRequest

TABLES, RUNS = "tables", "runs"


def run_file(out: Path, run: PlannedRun) -> Path:
    """Return where the trial of a run is or will be."""
    return out / RUNS / f"{run.name}.parquet"


def make_runs(out: Path, planned: Sequence[PlannedRun], tell: Callable[[str], None]) -> None:
    """Make the runs that are not there yet, and import them.

    Args:
        out: Folder of everything; tables, maps and robot file go into ``tables``, trials into ``runs``.
        planned: Runs to be there in the end.
        tell: Gets the name of each run that is made.

    Raises:
        BigantError: A table cannot be imported.
    """
    missing = [one for one in planned if not run_file(out, one).is_file()]
    if not missing:
        return
    _write_descriptions(out / TABLES)
    with earlier_files(overwrite=True, notify=tell):
        for one in missing:
            tell(one.name)
            table = out / TABLES / f"{one.name}.csv"
            write_table(simulated_run(PERIODS_S[one.gait], one.seed, one.fault), table)
            columns = str(out / TABLES / _map_name(one.gait))
            imported(ImportRequest(paths=(table,), map=columns, out=out / RUNS))


def _write_descriptions(folder: Path) -> None:
    """The robot as its builder describes it, and what the columns of the tables are."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {f"{ROBOT_NAME}.xml": described_robot(), f"{ROBOT_NAME}.toml": robot_file_text()}
    texts |= {_map_name(gait): map_text(period_s) for gait, period_s in PERIODS_S.items()}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def _map_name(gait: str) -> str:
    return f"map{gait}.toml"
