"""``bigant log trim``, ``merge``, ``repair``, ``export``, ``info``: files made of logs, what they hold."""

from collections.abc import Callable
from pathlib import Path

from model.errors import ConfigError, RecordError
from record.log.columns import GROUPS, check_groups
from record.log.damage import Pass
from record.log.export import export_table, export_trial, export_tum
from record.log.header import PREFIX
from record.log.reader import LogContents
from record.log.rewrite import Rewritten
from record.log.rewrite import repair as repair_log
from record.log.splice import cut_log, merge_logs
from record.log.survey import LogSurvey, survey_log
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.progress import ProgressLine
from robot.console.table import Column, row_lines, table_lines
from robot.report.run_date import utc_words
from robot.requests.log import (
    LogExportRequest,
    LogInfoRequest,
    LogMergeRequest,
    LogRepairRequest,
    LogTrimRequest,
)
from robot.run.gait_texts import gaits_of_log

TOPICS = (
    Column("", "d"), Column(""), Column("", ".0f"), Column(""), Column("", ".3f"), Column(""), Column(""),
)  # fmt: skip
SUFFIXES = {"trial": (".parquet", ".csv"), "csv": (".csv",), "parquet": (".parquet",)}


def trim(request: LogTrimRequest) -> ExitCode:
    """Cut a piece out of a log.

    Raises:
        RecordError: The span is empty, or a file cannot be read or written.
    """
    path, out, span = request.path, request.out, {"from_s": request.from_s, "to_s": request.to_s}
    return _write(f"reading {path}", out, path, lambda p: cut_log(path, out, **span, progress=p))


def merge(request: LogMergeRequest) -> ExitCode:
    """Merge logs.

    Raises:
        RecordError: They do not fit, or a file cannot be read or written.
    """
    note = f" of {len(request.paths)} logs"
    return _write(
        f"writing {request.out}",
        request.out,
        request.out,
        lambda p: merge_logs(request.paths, request.out, p),
        note,
    )


def repair(request: LogRepairRequest) -> ExitCode:
    """Repair a log.

    Raises:
        RecordError: Nothing can be read, or the new file cannot be written.
    """
    path, out = request.path, request.out
    target = out if out is not None else path.with_suffix(".repaired.mcap")
    if out is None and target.exists():
        raise RecordError(f"{target} is there already; name another file with --out")
    return _write(f"reading {path}", target, path, lambda p: repair_log(path, target, p))


def _write(
    label: str, out: Path, source: Path, write: Callable[[Pass], Rewritten], note: str = ""
) -> ExitCode:
    """Write a log with a line of progress; print what could not be read, and how much is in it."""
    progress = Pass()
    with ProgressLine(label, progress):
        done = write(progress)
    start_ns = survey_log(source).start_unix_ns if done.damages else 0
    for damage in done.damages:
        print(f"{'lost' if damage.content else 'note'}: {damage.words(start_ns)}")
    print(f"{out}: {done.kept} messages{note}")
    return ExitCode.OK


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
            what = all_but_raw if request.what is None else request.what
            written = export_table(path, out, check_groups(what), contents)
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
        other = {suffix for known in SUFFIXES.values() for suffix in known}
        if out is not None and out.suffix in other:
            raise ConfigError(
                "--out",
                f"for tum is the beginning of the names, {out.stem}_estimate.tum, not {out}",
            )
        return out if out is not None else path.with_suffix("")
    suffixes = SUFFIXES[kind]
    if out is None:
        stem = path.stem + "_trial" if kind == "trial" else path.stem
        return path.with_name(stem + suffixes[0])
    if out.suffix not in suffixes:
        raise ConfigError("--out", f"must end in {' or '.join(suffixes)} for {kind}, not {out}")
    return out


def info(request: LogInfoRequest) -> ExitCode:
    """Look through a log and list what it holds.

    Raises:
        RecordError: It cannot be read.
    """
    progress = Pass()
    with ProgressLine(f"reading {request.path}", progress):
        survey = survey_log(request.path, progress)
    print_result(_as_json(survey), row_lines(_rows(survey)), as_json=request.json)
    return ExitCode.VERDICT_FAILED if survey.damages or not survey.finished else ExitCode.OK


def _rate_hz(survey: LogSurvey) -> float:
    return 1 / survey.period_s if survey.period_s > 0 else float("nan")


def _rows(survey: LogSurvey) -> list[tuple[str, str]]:
    m = survey.metadata
    versions = [f"{k.removeprefix(PREFIX)} {v}" for k, v in m.items() if k.startswith(PREFIX)]
    rows = [
        ("file", f"{survey.path}, {survey.size / 1e6:.2f} MB"),
        ("robot", f"{m.get('robot', '?')}, legs {m.get('leg_names', '?')}"),
        ("run", f"{m.get('gait', '?')} at {m.get('frequency_hz', '?')} Hz on {m.get('hardware', '?')}"),
        ("started", utc_words(survey.first_unix_ns)),
        ("duration", f"{survey.duration_s:.3f} s"),
        ("ticks", f"{survey.ticks} at {_rate_hz(survey):.4g} Hz"),
        ("missing", f"{survey.lost} ticks lost from the file, {survey.skipped} periods without a tick"),
        ("robot file", f"{len(survey.config_text.encode())} bytes" if survey.config_text else "none"),
        ("software", m.get("software", "?") + (f" ({', '.join(versions)})" if versions else "")),
    ]  # fmt: skip
    rows += [
        ("gait file", f"{one.file}, {len(one.text.encode())} bytes (--json shows it)")
        for one in gaits_of_log(m)
    ]
    rows += [("warning", line) for line in m.get("warnings", "").splitlines()]
    if "merged" in m:
        rows.append(("merged from", m["merged"]))
    counts = [
        (t.count, "x", t.size / max(t.count, 1), "bytes", t.size / 1e6, "MB", t.kind)
        for t in survey.topics
    ]
    names = (topic.name for topic in survey.topics)
    rows += zip(names, table_lines(TOPICS, counts), strict=True)
    if survey.damages:
        rows += [("damage", one.words(survey.start_unix_ns)) for one in survey.damages]
    elif not survey.finished:
        rows.append(("damage", "the file has no proper end"))
    else:
        rows.append(("damage", "none"))
    return rows


def _as_json(survey: LogSurvey) -> dict[str, object]:
    start_ns = survey.start_unix_ns

    def seconds(unix_ns: int) -> float | None:
        return (unix_ns - start_ns) * 1e-9 if unix_ns >= 0 else None

    return {
        "path": survey.path,
        "size_bytes": survey.size,
        "finished": survey.finished,
        "first_unix_ns": survey.first_unix_ns,
        "duration_s": survey.duration_s,
        "ticks": survey.ticks,
        "rate_hz": _rate_hz(survey),
        "ticks_lost": survey.lost,
        "periods_skipped": survey.skipped,
        "topics": [
            {"name": t.name, "type": t.kind, "count": t.count, "bytes": t.size} for t in survey.topics
        ],
        "metadata": dict(survey.metadata),
        "damage": [
            {"offset": d.offset, "bytes": d.size, "from_s": seconds(d.from_ns),
             "to_s": seconds(d.to_ns), "reason": d.reason}
            for d in survey.damages
        ],
    }  # fmt: skip
