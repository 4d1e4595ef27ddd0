"""The parser of every command: options in full, and a mistake is answered by the command it was made in."""

import argparse
import difflib
import re
from collections.abc import Sequence
from typing import Any, NoReturn

OWN = "_parser"  # of parsed arguments: the parser of the command that was asked for


class CommandParser(argparse.ArgumentParser):
    """Takes no abbreviations (``--arm`` must not arm a robot), and says what a mistake was near to."""

    def __init__(self, **words: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **words})
        self.set_defaults(**{OWN: self})

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Parse; what is left over is the mistake of the command that was asked for."""
        found, left = self.parse_known_args(args, namespace)
        own: CommandParser = vars(found).pop(OWN)
        if left:
            options = [word for word in left if word.startswith("-")]
            near = own.near(options[0]) if options else ""
            own.error(f"unrecognized arguments: {' '.join(left)}{near}")
        return found

    def near(self, option: str) -> str:
        """Return a question for an option that is nearly one of this command's; empty otherwise."""
        known = [name for action in self._actions for name in action.option_strings]
        found = difflib.get_close_matches(option.split("=")[0], known, n=1)
        return f"; did you mean {found[0]}?" if found else ""

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
        super().error(re.sub(r"invalid _?(\w+?)_? value", r"invalid \1 value", message))
