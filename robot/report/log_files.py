"""``bigant log cut``, ``merge``, ``repair`` and ``export``: files made of logs, and a line about each."""

from collections.abc import Callable
from pathlib import Path

from model.errors import ConfigError, RecordError
from record.log.columns import GROUPS, check_groups
from record.log.damage import Pass
from record.log.export import export_table, export_trial, export_tum
from record.log.reader import LogContents
from record.log.rewrite import Rewritten
from record.log.rewrite import repair as repair_log
from record.log.splice import cut_log, merge_logs
from record.log.survey import survey_log
from robot.console.exit_codes import ExitCode
from robot.console.progress import ProgressLine
from robot.requests.log import LogCutRequest, LogExportRequest, LogMergeRequest, LogRepairRequest

SUFFIXES = {"trial": (".parquet", ".csv"), "csv": (".csv",), "parquet": (".parquet",)}


def cut(request: LogCutRequest) -> ExitCode:
    """Cut a piece out of a log.

    Raises:
        RecordError: The span is empty, or a file cannot be read or written.
    """
    path, out = request.path, request.out
    _written(
        f"reading {path}",
        out,
        path,
        lambda p: cut_log(path, out, from_s=request.from_s, to_s=request.to_s, progress=p),
    )
    return ExitCode.OK


def merge(request: LogMergeRequest) -> ExitCode:
    """Merge logs.

    Raises:
        RecordError: They do not fit, or a file cannot be read or written.
    """
    paths, out = request.paths, request.out
    _written(
        f"writing {out}", out, out, lambda p: merge_logs(paths, out, p), f" of {len(paths)} logs"
    )
    return ExitCode.OK


def repair(request: LogRepairRequest) -> ExitCode:
    """Repair a log.

    Raises:
        RecordError: Nothing can be read, or the new file cannot be written.
    """
    path, out = request.path, request.out
    target = out if out is not None else path.with_suffix(".repaired.mcap")
    if out is None and target.exists():
        raise RecordError(f"{target} is there already; name another file with --out")
    _written(f"reading {path}", target, path, lambda p: repair_log(path, target, p))
    return ExitCode.OK


def _written(
    label: str, out: Path, source: Path, write: Callable[[Pass], Rewritten], note: str = ""
) -> None:
    """Write a log with a line of progress; print what could not be read, and how much is in it."""
    progress = Pass()
    with ProgressLine(label, progress):
        done = write(progress)
    start_ns = survey_log(source).start_unix_ns if done.damages else 0
    for damage in done.damages:
        print(f"{'lost' if damage.content else 'note'}: {damage.words(start_ns)}")
    print(f"{out}: {done.kept} messages{note}")


def export(request: LogExportRequest) -> ExitCode:
    """Export a log.

    Raises:
        ConfigError: Options that do not fit each other.
        RecordError: A file cannot be read or written.
    """
    path, kind = request.path, request.format
    if request.what is not None and kind not in {"csv", "parquet"}:
        raise ConfigError("--what", f"chooses columns of csv and parquet; {kind} has its own")
    out = _target(path, kind, request.out)
    contents = LogContents()
    with ProgressLine(f"reading {path}", contents.progress):
        if kind == "trial":
            written = export_trial(path, out, contents)
        elif kind == "tum":
            written = export_tum(path, out, contents)
        else:
            all_but_raw = ",".join(name for name in GROUPS if name != "raw")
            groups = check_groups(request.what if request.what is not None else all_but_raw)
            written = export_table(path, out, groups, contents)
    if contents.damage:
        print(f"{path}: {contents.damage}")
    for file in written:
        print(f"{file.path}" + (f": {file.rows} rows" if file.rows else ""))
    if not written:
        print(f"{path} holds no pose that is known")
        return ExitCode.VERDICT_FAILED
    return ExitCode.OK


def _target(path: Path, kind: str, out: Path | None) -> Path:
    if kind == "tum":
        return out if out is not None else path.with_suffix("")
    suffixes = SUFFIXES[kind]
    if out is None:
        stem = path.stem + "_trial" if kind == "trial" else path.stem
        return path.with_name(stem + suffixes[0])
    if out.suffix not in suffixes:
        raise ConfigError("--out", f"must end in {' or '.join(suffixes)} for {kind}, not {out}")
    return out
