"""What the product imports is declared in pyproject.toml, and what is declared is imported."""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

from tests.source_trees import nodes_of
from tests.test_layers import OURS, ROOT, SOURCES

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# Import names whose distribution need not be installed here, or has several names.
DISTRIBUTIONS = {"rerun": "rerun-sdk", "mpl_toolkits": "matplotlib"}
# ROS 2 brings it; the type checker brings the other.
NOT_ON_AN_INDEX = {"rclpy", "_typeshed"}
# Loaded by pytest itself, so whoever needs it has it.
PLUGIN_OF = {"pytest"}


def name(requirement: str) -> str:
    """The distribution of a requirement, as an index spells it."""
    found = re.match(r"[\w.-]+", requirement)
    assert found
    return re.sub(r"[-_.]+", "-", found.group()).lower()


def imported(path: Path) -> Iterator[str]:
    """Top-level packages that a module imports, at its top, in a function, or by name."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module.partition(".")[0]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute | ast.Name):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
            first = node.args[0] if node.args else None
            if called == "import_module" and isinstance(first, ast.Constant):
                yield str(first.value).partition(".")[0]


def used_distributions() -> set[str]:
    installed = packages_distributions()
    modules = {module for path in SOURCES for module in imported(path)}
    others = modules - set(OURS) - {"bigant"} - set(sys.stdlib_module_names) - NOT_ON_AN_INDEX
    unknown = {m for m in others if m not in installed and m not in DISTRIBUTIONS}
    assert not unknown, "imported, and no package that is installed here has it"
    return {name(DISTRIBUTIONS.get(m) or installed[m][0]) for m in others}


def test_what_is_imported_is_declared_and_what_is_declared_is_imported() -> None:
    extras = PROJECT["optional-dependencies"]
    apart = {"dev", "eval"}  # tools of the tests; evo is run as a command
    declared = {name(one) for one in PROJECT["dependencies"]}
    declared |= {name(one) for extra in extras.keys() - apart for one in extras[extra]}
    used = used_distributions()
    assert used - PLUGIN_OF - declared == set(), "import it no more, or declare it"
    assert declared - used == set(), "nothing imports it any more"


def test_every_dependency_has_its_version_in_the_constraints() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    held = {name(line) for line in lines if line.strip()}
    wanted = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["dev"]]
    assert {name(one) for one in wanted} - held - {"bigant"} == set()
