"""Every command there is: help, examples that parse, --json where it reports, exit codes said."""

import argparse
import re
import shlex
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

from model.errors import BigantError, BusError, ConfigError, GaitRefused, RecordError
from robot.campaign.plan import CAMPAIGN_PAGE
from robot.cli import main as cli
from robot.cli.commands import COMMANDS, GROUP_HELP, HEADINGS
from robot.cli.examples import EXAMPLES
from robot.cli.help_pages import PAGES, page_hint
from robot.cli.old_names import LAST_VERSION, OLD_NAMES, with_new_names
from robot.console.exit_codes import ExitCode
from robot.console.shipped import ROBOT_FILE_PAGE
from tests.test_docs import anchors_of

ROOT = Path(__file__).resolve().parents[3]
# What does something rather than report: its result is a file, a moving robot, or a program.
ACTS = {
    ("robot", "export"): "writes files",
    ("robot", "new"): "writes a robot file; bigant robot show FILE --json",
    ("gap", "demo"): "writes runs and diagnosis.json into its folder",
    ("sim", "render"): "draws",
    ("drive",): "bigant show LOG --json has the summary",
    ("view",): "draws",
    ("completion",): "prints a script",
    ("model", "figures"): "draws",
    ("log", "repair"): "writes a log; bigant log info --json",
    ("log", "trim"): "writes a log",
    ("log", "merge"): "writes a log",
    ("log", "export"): "writes tables",
    ("servo", "setup"): "writes servos after a yes",
    ("servo", "backup"): "writes a file",
    ("servo", "restore"): "writes servos after a yes",
    ("sim", "serve"): "serves",
    ("bringup",): "asks; first_day.json in its folder has every finding",
}


def leaves(
    parser: argparse.ArgumentParser, words: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], argparse.ArgumentParser]]:
    """All commands with their parsers."""
    groups = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not groups:
        yield words, parser
    for group in groups:
        for name, child in group.choices.items():
            yield from leaves(child, (*words, name))


FULL = cli.full_parser()
LEAVES = dict(leaves(FULL))


def parse(line: str) -> argparse.Namespace:
    """Parse a command line as a shell would hand it over."""
    words = shlex.split(line, comments=True)
    assert words[0] == "bigant", line
    if ">" in words:
        words = words[: words.index(">")]
    return FULL.parse_args(words[1:])


@pytest.mark.parametrize("words", LEAVES, ids=" ".join)
def test_a_command_explains_itself(words: tuple[str, ...]) -> None:
    parser = LEAVES[words]
    text = parser.format_help()
    assert parser.description, "what it does"
    assert "exit codes: 0 ok" in text
    assert EXAMPLES.get(" ".join(words)), f"add examples to robot/cli/examples.py: {words}"
    assert text.startswith(f"most common: {EXAMPLES[' '.join(words)][0]}\n\nusage: ")
    for line in EXAMPLES[" ".join(words)]:
        assert line in text, "as it is, not refilled"
        assert tuple(shlex.split(line)[1 : 1 + len(words)]) == words
        parse(line)


def test_what_reports_can_be_read_by_programs() -> None:
    reports = {words for words, parser in LEAVES.items() if "--json" in parser.format_usage()}
    assert not reports & ACTS.keys(), "either it reports, or it stands in ACTS"
    assert reports | ACTS.keys() == LEAVES.keys(), "either it reports, or it stands in ACTS"


def test_all_commands_are_walked() -> None:
    assert set(LEAVES) == {tuple(command.split()) for command in COMMANDS}
    assert set(ACTS) <= set(LEAVES)
    assert all(text and text[-1] != "." for text in COMMANDS.values())


def test_the_top_level_help_lists_every_command_in_groups_on_one_screen() -> None:
    listed = [name for names in HEADINGS.values() for name in names]
    assert sorted(listed) == sorted({command.split()[0] for command in COMMANDS})
    lines = FULL.format_help().rstrip("\n").splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    for heading, names in HEADINGS.items():
        assert any(
            line.split()[: len(heading.split()) + 1] == [*heading.split(), names[0]]
            for line in lines
        )


@pytest.mark.parametrize("group", GROUP_HELP)
def test_help_of_a_group_begins_with_its_first_command(
    group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.run([group, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"most common: bigant {group} ")


@pytest.mark.parametrize("old", OLD_NAMES)
def test_an_old_name_works_and_names_the_new_one(
    old: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = with_new_names([*old.split(), "--json"])
    assert command == [*OLD_NAMES[old].split(), "--json"]
    assert capsys.readouterr() == (
        "",
        f"note: bigant {old} is now bigant {OLD_NAMES[old]}; the old name works in version "
        f"{LAST_VERSION} only\n",
    )
    words = tuple(word for word in OLD_NAMES[old].split() if word[:2] != "--" and word != "none")
    assert words in LEAVES or words[0] in GROUP_HELP
    assert tuple(old.split()) not in LEAVES, "it cannot be both"


def test_todays_names_are_taken_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["force", "watch"], ["servo", "setup"], ["log", "trim", "cut"], ["ftx"], []):
        assert with_new_names(words) == words
    assert capsys.readouterr() == ("", "")


def test_old_names_leave_with_their_version() -> None:
    assert version("bigant").startswith(("0.1", LAST_VERSION)), "remove robot/cli/old_names.py"


def test_the_lazy_parser_and_the_full_one_are_the_same() -> None:
    for words in LEAVES:
        lazy = dict(leaves(cli._parser(list(words))))[words]
        assert lazy.format_help() == LEAVES[words].format_help()


@pytest.mark.parametrize(
    ("error", "page"),
    [
        (BusError("no port"), "docs/tutorial.md#wiring"),
        (RecordError("no log"), "docs/log.md"),
        (GaitRefused("servo.max_speed", 9, 4, "rad/s"), "docs/gaits.md"),
        (ConfigError("leg.crank", "too long"), ROBOT_FILE_PAGE),
        (ConfigError("lab.toml: legs.servo_zero[2]", "too large"), ROBOT_FILE_PAGE),
        (ConfigError("lab.toml", "the robot file cannot be read"), ROBOT_FILE_PAGE),
        (ConfigError("lab.toml: cases.repeats", "is missing", CAMPAIGN_PAGE), CAMPAIGN_PAGE),
        (ConfigError("faults.toml", "the scenario cannot be read"), ""),
        (ConfigError("faults.toml: servo", "must be a table"), ""),
        (ConfigError("--port", "taken"), ""),
        (RecordError("broken (see docs/replay.md)"), ""),
    ],
)
def test_an_error_names_the_page_that_helps(error: BigantError, page: str) -> None:
    assert page_hint(error) == (f" (see {page})" if page else "")


def test_pages_that_errors_name_exist() -> None:
    named = {page for _, page in PAGES} | {ROBOT_FILE_PAGE, CAMPAIGN_PAGE}
    for path in sorted((ROOT / "robot").rglob("*.py")):
        named |= set(re.findall(r"docs/[\w/]+\.md(?:#[\w-]+)?", path.read_text(encoding="utf-8")))
    assert len(named) > 5
    for page in named:
        file, _, anchor = page.partition("#")
        assert (ROOT / file).is_file(), page
        assert not anchor or anchor in anchors_of(ROOT / file), page


def test_a_mistake_is_one_line_with_its_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["log", "info", "absent.mcap"]) == ExitCode.LOG
    printed = capsys.readouterr().err
    assert printed.splitlines() == [printed.rstrip("\n")]
    assert printed.endswith("(see docs/log.md)\n")
