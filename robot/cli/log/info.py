"""``bigant log info``: what a log holds.

Duration, rate, ticks and missing ticks, topics, robot, gait, software versions and damage. Damage that was
stepped over makes the exit code 1.
"""

import argparse
import json
import time
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from record.log.survey import LogSurvey


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument("--json", action="store_true", help="as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Look through a log and say what it holds.

    Raises:
        RecordError: It cannot be read.
    """
    from record.log.salvage import Pass
    from record.log.survey import survey_log
    from robot.console.progress import ProgressLine
    from robot.console.table import row_lines

    progress = Pass()
    with ProgressLine(f"reading {options.path}", progress):
        survey = survey_log(options.path, progress)
    if options.json:
        print(json.dumps(_as_json(survey), indent=2))
    else:
        for line in row_lines(_rows(survey)):
            print(line)
    return ExitCode.VERDICT_FAILED if survey.damages or not survey.finished else ExitCode.OK


def _rate_hz(survey: "LogSurvey") -> float:
    return 1 / survey.period_s if survey.period_s > 0 else float("nan")


def _rows(survey: "LogSurvey") -> list[tuple[str, str]]:
    from record.log.salvage import damage_words
    from record.log.versions import PREFIX

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


def _as_json(survey: "LogSurvey") -> object:
    from robot.console.json_output import plain

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
