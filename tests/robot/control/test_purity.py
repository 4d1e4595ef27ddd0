"""The step is pure and a real drive loads no simulator: looked for in fresh interpreters, not promised."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
OURS = ("robot", "model", "gaits", "drivers", "record", "sim_hw", "gap")
# Whatever the step calls, directly or not, these are not even loaded.
NEVER = ("serial", "dynamixel_sdk", "mujoco", "gap", "sim_hw", "mcap", "matplotlib")
# numba loads these for itself; none of our modules may import them.
NOT_OURS = ("socket", "threading", "time", "multiprocessing", "asyncio", "subprocess", *NEVER)
LOADED = "import json, sys; print(json.dumps(sorted(sys.modules)))"


def loaded_after(code: str) -> list[str]:
    """Modules that a fresh interpreter has loaded after some code."""
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{LOADED}"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    modules: list[str] = json.loads(done.stdout.splitlines()[-1])
    return modules


def under(modules: list[str], names: tuple[str, ...]) -> list[str]:
    return [module for module in modules if module.split(".")[0] in names]


def imports_of(module: str) -> set[str]:
    """Top-level names that a module of ours imports when it is loaded: not in functions or for types."""
    place = ROOT / module.replace(".", "/")
    path = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    names: set[str] = set()
    nodes: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        if isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
        for_types = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        if not (for_types or isinstance(node, ast.FunctionDef)):
            nodes += ast.iter_child_nodes(node)
    return names


@pytest.mark.soak
def test_the_control_step_loads_no_device_no_simulator_and_no_diagnosis() -> None:
    """A robot file without effects: what one with effects needs is loaded with its controller."""
    modules = loaded_after(
        "from robot.config.robot_file import load_robot\n"
        "from robot.control.controller import Controller\n"
        "Controller(load_robot(), (None,) * 6, armed=False).initial()"
    )
    assert under(modules, NEVER) == []
    ours = [module for module in under(modules, OURS) if "." in module]
    assert len(ours) > 30
    impure = {module: sorted(imports_of(module) & set(NOT_OURS)) for module in ours}
    assert not {module: names for module, names in impure.items() if names}


def test_a_real_drive_loads_no_simulator() -> None:
    """Up to the port, which is not there: all that `bigant drive --hardware PORT` imports is loaded."""
    modules = loaded_after(
        "from robot.cli.main import run\n"
        "words = 'drive --hardware /nowhere/ttyUSB9 --force-unit none --log none --armed'\n"
        "assert run(words.split()) == 3"
    )
    assert under(modules, ("mujoco", "sim_hw", "gap")) == []
    assert {"robot.run.hardware", "robot.run.loop", "robot.view.screen", "serial"} <= set(modules)
