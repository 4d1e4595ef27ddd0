"""``bigant model figures``."""

import argparse

from model.errors import ModelError
from robot.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""


def run(options: argparse.Namespace) -> ExitCode:
    """Run the action."""
    raise ModelError("bigant model figures is not written yet")
