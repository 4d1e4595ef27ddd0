"""Write docs/reference/cli.md from the parser itself: ``python docs/write_cli_reference.py``."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from robot.cli.commands import HEADINGS
from robot.cli.examples import EXAMPLES
from robot.cli.main import full_parser
from robot.cli.old_names import LAST_VERSION, OLD_NAMES

PAGE = Path(__file__).resolve().parent / "reference" / "cli.md"
HEAD = """# Commands

Written by `make docs` from the command line's own parser; do not edit. Exit codes of all of them:
[how to](../howto.md#use-it-from-a-program).
"""


def page() -> str:
    """Return the page."""
    parts = [HEAD]
    commands = list(_commands(full_parser(), ()))
    for heading, names in HEADINGS.items():
        links = [
            f"[`{' '.join(words)}`](#{_anchor(words)})"
            for name in names
            for words, _, _ in commands
            if words[0] == name
        ]
        parts.append(f"- **{heading.capitalize()}:** {', '.join(links)}")
    parts.append(
        f"\nNames of version 0.1 that still work in {LAST_VERSION}, with a line on stderr:\n"
    )
    parts += ["| before | now |", "|---|---|"]
    parts += [f"| `bigant {old}` | `bigant {new}` |" for old, new in OLD_NAMES.items()]
    for words, parser, summary in commands:
        parts.append(_section(words, parser, summary))
    return "\n".join(parts) + "\n"


def _anchor(words: tuple[str, ...]) -> str:
    return "bigant-" + "-".join(words)


def _commands(
    parser: argparse.ArgumentParser, words: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], argparse.ArgumentParser, str]]:
    for action in parser._actions:
        if not isinstance(action, argparse._SubParsersAction):
            continue
        summaries = {choice.dest: choice.help or "" for choice in action._choices_actions}
        for name, child in action.choices.items():
            inner = list(_commands(child, (*words, name)))
            yield from inner or [((*words, name), child, summaries.get(name, ""))]


def _section(words: tuple[str, ...], parser: argparse.ArgumentParser, summary: str) -> str:
    lines = [
        f"\n## bigant {' '.join(words)}\n",
        f"{summary[:1].upper()}{summary[1:]}{'' if summary.endswith('?') else '.'}\n",
    ]
    description = " ".join((parser.description or "").split())
    if description:
        lines.append(f"{_plain(description)}\n")
    rows = [_row(action) for action in parser._actions if action.dest != "help"]
    if rows:
        lines += ["| argument | meaning |", "|---|---|", *rows, ""]
    lines += ["```sh", *EXAMPLES.get(" ".join(words), ()), "```"]
    return "\n".join(lines)


def _row(action: argparse.Action) -> str:
    value = ""
    if action.nargs != 0:
        choices = "{" + ",".join(map(str, action.choices)) + "}" if action.choices else ""
        metavar = action.metavar if isinstance(action.metavar, str) else ""
        value = metavar or choices or action.dest.upper()
    if action.nargs in {"?", "*"}:
        value = f"[{value}]"
    if action.nargs in {"*", "+"}:
        value += " ..."
    name = ", ".join(f"{option} {value}".strip() for option in action.option_strings) or value
    needed = " (needed)" if action.option_strings and action.required else ""
    text = _plain((action.help or "").replace("%%", "%"))
    return f"| `{name.replace('|', chr(92) + '|')}` | {text}{needed} |"


def _plain(text: str) -> str:
    """Text that Markdown leaves alone."""
    for mark in ("|", "*", "<", "_"):
        text = text.replace(mark, f"\\{mark}")
    return text


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
