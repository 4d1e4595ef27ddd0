"""``bigant sim effects``: what can be made wrong with the virtual robot.

A table of all effects with their parameters, units and ranges, and where each acts. Sizes are a mild and
a strong one; `bigant sim run --effect NAME` takes the strong one. Effects marked * are not among those
that a gap diagnosis knows by name.
"""

import argparse

from robot.console.arguments import add_json
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_json(parser, "the list")


def run(options: argparse.Namespace) -> ExitCode:
    """List the effects."""
    from robot.virtual.listing import list_effects

    return list_effects(as_json=options.json)
