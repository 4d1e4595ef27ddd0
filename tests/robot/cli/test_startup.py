"""Help answers at once: modules of commands import nothing that takes long."""

import subprocess
import sys

from robot.cli.commands import COMMANDS

HEAVY = ("numpy", "scipy", "matplotlib", "mcap", "zstandard", "tomlkit", "serial", "mujoco")
THICK = {("drive",), ("show",)}  # hold their work themselves


def test_the_module_of_a_command_imports_nothing_heavy() -> None:
    modules = [command.module for command in COMMANDS if command.words not in THICK]
    code = f"""
import importlib, sys
import robot.cli.main
for name in {modules}:
    importlib.import_module(name)
    heavy = [module for module in {HEAVY} if module in sys.modules]
    assert not heavy, (name, heavy)
"""
    subprocess.run([sys.executable, "-c", code], check=True)
