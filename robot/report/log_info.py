"""``bigant log info``: what a log holds, as a table and as JSON."""

import json
import time
from pathlib import Path

from record.log.damage import Pass, damage_words
from record.log.header import PREFIX
from record.log.survey import LogSurvey, survey_log
from robot.console.exit_codes import ExitCode
from robot.console.json_output import plain
from robot.console.progress import ProgressLine
from robot.console.table import row_lines


def info(path: Path, *, as_json: bool) -> ExitCode:
    """Look through a log and list what it holds.

    Raises:
        RecordError: It cannot be read.
    """
    progress = Pass()
    with ProgressLine(f"reading {path}", progress):
        survey = survey_log(path, progress)
    if as_json:
        print(json.dumps(_as_json(survey), indent=2))
    else:
        print("\n".join(row_lines(_rows(survey))))
    return ExitCode.VERDICT_FAILED if survey.damages or not survey.finished else ExitCode.OK


def _rate_hz(survey: LogSurvey) -> float:
    return 1 / survey.period_s if survey.period_s > 0 else float("nan")


def _rows(survey: LogSurvey) -> list[tuple[str, str]]:
    m = survey.metadata
    begun = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(survey.first_unix_ns // 10**9))
    versions = [f"{k.removeprefix(PREFIX)} {v}" for k, v in m.items() if k.startswith(PREFIX)]
    rows = [
        ("file", f"{survey.path}, {survey.size / 1e6:.2f} MB"),
        ("robot", f"{m.get('robot', '?')}, legs {m.get('leg_names', '?')}"),
        (
            "run",
            f"{m.get('gait', '?')} at {m.get('frequency_hz', '?')} Hz on {m.get('hardware', '?')}",
        ),
        ("begun", begun),
        ("duration", f"{survey.duration_s:.3f} s"),
        ("ticks", f"{survey.ticks} at {_rate_hz(survey):.4g} Hz"),
        (
            "missing",
            f"{survey.lost} ticks lost from the file, {survey.skipped} periods without a tick",
        ),
        (
            "robot file",
            f"{len(survey.config_text.encode())} bytes" if survey.config_text else "none",
        ),
        ("software", m.get("software", "?") + (f" ({', '.join(versions)})" if versions else "")),
    ]
    if "merged" in m:
        rows.append(("merged from", m["merged"]))
    rows += [
        (topic.name, f"{topic.count:>8} x {topic.size / topic.count if topic.count else 0:7.0f} bytes  "
         f"{topic.size / 1e6:9.3f} MB  {topic.kind}")
        for topic in survey.topics
    ]  # fmt: skip
    if survey.damages:
        rows.append(("damage", damage_words(survey.damages, survey.start_unix_ns)))
    elif not survey.finished:
        rows.append(("damage", "the file has no proper end"))
    else:
        rows.append(("damage", "none"))
    return rows


def _as_json(survey: LogSurvey) -> object:
    start_ns = survey.start_unix_ns

    def seconds(unix_ns: int) -> float | None:
        return (unix_ns - start_ns) * 1e-9 if unix_ns >= 0 else None

    return plain({
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
    })  # fmt: skip
