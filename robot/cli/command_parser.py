"""The parser of one command: full option names, suggestions for mistakes, an example first."""

import argparse
import difflib
import re
from collections.abc import Sequence
from typing import Any, NoReturn

from robot.console.printable import printable

EXAMPLES_HEAD = "more examples:"
OWN = "_parser"  # of parsed arguments: the parser of the command that was typed


class CommandParser(argparse.ArgumentParser):
    """Takes no abbreviations (``--arm`` must not arm a robot) and suggests what was probably meant.

    Args:
        example: What most people type; the help begins with it.
        overview: The whole help, in place of the one that argparse writes.
        words: For ``argparse``.
    """

    def __init__(self, *, example: str = "", overview: str = "", **words: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **words})
        self.set_defaults(**{OWN: self})
        self._example, self._overview = example, overview

    def format_help(self) -> str:
        """Return the help: the overview of all commands, or what most people type and then the rest."""
        if self._overview:
            return self._overview
        text = super().format_help()
        return f"most common: {self._example}\n\n{text}" if self._example else text

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Parse; what is left over is a mistake, and the command that was typed answers it."""
        options, left = self.parse_known_args(args, namespace)
        own: CommandParser = vars(options).pop(OWN)
        if left:
            unknown = [word for word in left if word.startswith("-")]
            near = own.near(unknown[0]) if unknown else ""
            own.error(f"unrecognized arguments: {' '.join(left)}{near}")
        return options

    def near(self, option: str) -> str:
        """Return a question for an option that is nearly one of this command's; empty otherwise."""
        known = [name for action in self._actions for name in action.option_strings]
        near = difflib.get_close_matches(option.split("=")[0], known, n=1)
        return f"; did you mean {near[0]}?" if near else ""

    def error(self, message: str) -> NoReturn:
        """Exit with usage and the mistake in words."""
        for action in self._actions:
            if not isinstance(action, argparse._SubParsersAction):
                continue
            names = sorted(action.choices)
            if f"required: {action.metavar}" in message:
                message += f"; {action.metavar} is one of: {', '.join(names)}"
            if wrong := re.search(r"invalid choice: '([^']*)'", message):
                near = difflib.get_close_matches(wrong.group(1), names, n=1)
                message += f"; did you mean {near[0]}?" if near else ""
        super().error(printable(re.sub(r"invalid _?(\w+?)_? value", r"invalid \1 value", message)))


class HelpFormatter(argparse.HelpFormatter):
    """Keeps the lines of examples; fills everything else."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if not text.startswith(EXAMPLES_HEAD):
            return super()._fill_text(text, width, indent)
        examples, _, rest = text.partition("\n\n")
        return f"{examples}\n\n{super()._fill_text(rest, width, indent)}"
