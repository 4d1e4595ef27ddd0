"""What has been done on the first day: the file that a later start goes on from, and a scenario file."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tomlkit

from drivers.dynamixel.settings import ServoBusSettings
from model.errors import ConfigError
from record.earlier_file import earlier_files
from record.json_text import parse_json
from record.toml_file import reading
from record.whole_file import write_text
from robot.bringup.first_day.curve import DayCurve, read_curve
from robot.bringup.first_day.day import Fact
from robot.bringup.preflight.finding import CheckVerdict, Finding
from robot.report.run_date import utc_words

KIND = "bigant bringup"
VERSION = 1
STATE_FILE = "first_day.json"
FACTS_FILE = "measured.toml"
PAGE_FILE = "first_day.html"
DONE, SKIPPED, REFUSED, ABORTED = "done", "skipped", "refused", "aborted"
TABLES = ("servo", "force_unit", "adapter")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one step.

    Attributes:
        number: Step.
        key: Its short name.
        ended: ``done``; ``skipped`` by the person; ``refused`` (not armed, or a step before is missing);
            ``aborted`` by Ctrl-C or an error.
        verdict: Pass, warn, fail or skip.
        unix_ns: When it ended.
        seconds: How long it took, by the devices' clock.
        mapping: Digest of the robot file's ids, signs and zeros.
        findings: What was found.
        facts: What was settled.
        curves: What each leg did.
    """

    number: int
    key: str
    ended: str
    verdict: CheckVerdict
    unix_ns: int
    seconds: float
    mapping: str
    findings: tuple[Finding, ...]
    facts: tuple[Fact, ...]
    curves: tuple[DayCurve, ...] = ()

    @property
    def good(self) -> bool:
        """Whether it need not be done again."""
        return self.ended in {DONE, SKIPPED} and self.verdict is not CheckVerdict.FAIL


@dataclass(frozen=True, slots=True)
class Record:
    """The day so far.

    Attributes:
        robot: Name of the robot.
        hardware: Port, or ``virtual``.
        outcomes: Every outcome, oldest first; of a step that was repeated the last one counts.
    """

    robot: str
    hardware: str
    outcomes: tuple[Outcome, ...] = ()

    @property
    def latest(self) -> dict[int, Outcome]:
        """Last outcome of each step, by number, in the order of the steps."""
        found = {outcome.number: outcome for outcome in self.outcomes}
        return dict(sorted(found.items()))

    def settled(self, number: int, mapping: str = "") -> bool:
        """Whether a step need not be done again; with a mapping only if it was the same then."""
        outcome = self.latest.get(number)
        return outcome is not None and outcome.good and mapping in {"", outcome.mapping}

    def passed(self, number: int, mapping: str = "") -> bool:
        """Whether a step was done, and not only skipped; with a mapping only if it was the same then."""
        return self.settled(number, mapping) and self.latest[number].ended == DONE

    @property
    def facts(self) -> dict[tuple[str, str], tuple[Fact, Outcome]]:
        """Newest fact of each key, with the outcome that it is from."""
        return {
            (fact.table, fact.key): (fact, outcome)
            for outcome in self.outcomes
            for fact in outcome.facts
        }


def mapping_digest(settings: ServoBusSettings) -> str:
    """Return what changes when ids, signs or zeros of the robot file change."""
    columns = [settings.ids.tolist(), settings.signs.tolist(), settings.zeros.tolist()]
    return hashlib.sha256(json.dumps(columns).encode()).hexdigest()[:16]


def save(record: Record, folder: Path) -> None:
    """Write state and measured facts, each whole or not at all.

    Raises:
        RecordError: A file cannot be written.
    """
    outcomes = [
        {
            **asdict(outcome),
            "verdict": outcome.verdict.value,
            "findings": [{**asdict(f), "verdict": f.verdict.value} for f in outcome.findings],
        }
        for outcome in record.outcomes
    ]
    document = {
        "kind": KIND, "version": VERSION, "robot": record.robot, "hardware": record.hardware,
        "outcomes": outcomes,
    }  # fmt: skip
    for name, text in (
        (STATE_FILE, json.dumps(document, indent=1) + "\n"),
        (FACTS_FILE, facts_text(record)),
    ):
        rewrite(folder / name, text)


def rewrite(path: Path, text: str) -> None:
    """Write a file of the day again; what it said before is in it as well.

    Raises:
        RecordError: It cannot be written.
    """
    with earlier_files(overwrite=True, notify=lambda _: None):
        write_text(path, text, "--folder")


def load(folder: Path) -> Record | None:
    """Read the state of a folder; None where there is none.

    Raises:
        ConfigError: It cannot be read.
    """
    path = folder / STATE_FILE
    if not path.exists():
        return None
    with reading(path, "the state of the first day") as text:
        try:
            data = parse_json(text)
            if data["kind"] != KIND or data["version"] != VERSION:
                raise ValueError("it is of another program or version")
            outcomes = tuple(_outcome(one) for one in data["outcomes"])
            return Record(str(data["robot"]), str(data["hardware"]), outcomes)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            reason = f"cannot be read ({error}): choose another --folder, or delete it"
            raise ConfigError(STATE_FILE, reason) from error


def _outcome(data: dict[str, Any]) -> Outcome:
    findings = tuple(
        Finding(
            one["name"],
            CheckVerdict(one["verdict"]),
            one["found"],
            one["advice"],
            tuple(one.get("legs", ())),
            one.get("part", ""),
        )
        for one in data["findings"]
    )
    facts = tuple(Fact(**one) for one in data["facts"])
    curves = tuple(map(read_curve, data.get("curves", ())))
    read = {"findings": findings, "facts": facts, "curves": curves}
    return Outcome(**{**data, "verdict": CheckVerdict(data["verdict"]), **read})


def facts_text(record: Record) -> str:
    """Return the measured facts as a scenario file, each below a comment that says how it was measured."""
    lines = [
        f"# Measured by bigant bringup on {record.robot} at {record.hardware}. A scenario file: virtual",
        "# devices behave as these did with bigant drive --scenario; what is not here is still assumed.",
    ]
    facts: Sequence[tuple[Fact, Outcome]] = list(record.facts.values())
    for table in TABLES:
        mine = [(fact, outcome) for fact, outcome in facts if fact.table == table]
        if mine:
            lines += ["", f"[{table}]"]
        for fact, outcome in mine:
            lines.append(f"# step {outcome.number}, {utc_words(outcome.unix_ns)}: {fact.how}")
            lines.append(f"{fact.key} = {tomlkit.item(fact.value).as_string()}")
    return "\n".join(lines) + "\n"
