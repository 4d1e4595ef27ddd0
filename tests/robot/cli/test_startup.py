"""Help answers at once: what a command is asked for imports nothing that takes long."""

import importlib
import subprocess
import sys
from typing import get_type_hints

from robot.cli.commands import COMMANDS, request_of
from robot.console.arguments import WORK
from robot.console.exit_codes import ExitCode

HEAVY = ("numpy", "scipy", "matplotlib", "mcap", "zstandard", "tomlkit", "serial", "mujoco")


def test_help_imports_nothing_heavy() -> None:
    code = f"""
import sys
import robot.cli.main
from robot.cli.commands import COMMANDS, request_of
assert not [module for module in sys.modules if module.startswith("robot.requests.")]
for command in COMMANDS:
    request_of(command)
    heavy = [module for module in {HEAVY} if module in sys.modules]
    assert not heavy, (command, heavy)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_function_that_a_request_names_takes_it() -> None:
    for command in COMMANDS:
        request = request_of(command)
        module, _, function = getattr(request, WORK).partition(":")
        hints = get_type_hints(getattr(importlib.import_module(f"robot.{module}"), function))
        assert hints == {"request": request, "return": ExitCode}, command
