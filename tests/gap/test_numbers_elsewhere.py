"""A number of the diagnosis that decides an answer is in ``gap.constants``; every other one has a reason.

``numbers_elsewhere.toml`` lists the others by reason. What a number does no test can see; this one makes
sure that nobody adds one without saying why it decides nothing.
"""

import ast
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from gap import constants
from gap.constants import Constant
from model.parameters.toml_table import parse_toml
from tests.source_trees import nodes_of, tree_of

ROOT = Path(__file__).resolve().parents[2]
LISTED = parse_toml(
    (ROOT / "tests" / "gap" / "numbers_elsewhere.toml").read_text(encoding="utf-8"), "listed"
)
REASONS = {reason: modules for reason, modules in LISTED.items() if reason != "in_functions"}
SOURCES = sorted(
    path
    for path in (ROOT / "gap").rglob("*.py")
    if (ROOT / "gap" / "constants") not in path.parents
)
ENGINE = ("gap/diagnosis", "gap/residuals", "gap/search")
PLAIN = {0.0, 0.5, 1.0, 2.0}  # a half, a whole, twice: as often arithmetic as a threshold
ROUNDING = 1e-5  # smaller ones keep from dividing by 0
ADVICE = (
    "does it decide an answer (a threshold, a weight, a prior, a level)? Then put it into gap/constants "
    "and measure it (python -m benchmarks.gap.constants --only NAME). If not, list it in "
    "tests/gap/numbers_elsewhere.toml under its reason"
)


def names_with_numbers(body: Iterable[ast.stmt]) -> Iterator[str]:
    """Names on the level of a module whose value is written with a number."""
    for one in body:
        if isinstance(one, ast.Assign | ast.AnnAssign) and one.value and any(numbers_in(one.value)):
            targets = one.targets if isinstance(one, ast.Assign) else [one.target]
            for target in targets:
                yield from (n.id for n in ast.walk(target) if isinstance(n, ast.Name))


def numbers_in(node: ast.AST) -> Iterator[ast.Constant]:
    for one in ast.walk(node):
        number = isinstance(one, ast.Constant) and isinstance(one.value, int | float)
        if isinstance(one, ast.Constant) and number and not isinstance(one.value, bool):
            yield one


def fractions_compared(nodes: Iterable[ast.AST]) -> set[str]:
    """Numbers with a point that are written in a comparison, as text; neither plain nor rounding."""
    return {
        repr(one.value)
        for node in nodes
        if isinstance(node, ast.Compare)
        for one in numbers_in(node)
        if isinstance(one.value, float) and one.value not in PLAIN
        if ROUNDING < one.value < 1.0 - ROUNDING or one.value > 1.0 + ROUNDING
    }


def module_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_a_number_outside_gap_constants_has_a_reason() -> None:
    written = {
        (module_of(path), name)
        for path in SOURCES
        for name in names_with_numbers(tree_of(path).body)
    }
    listed = Counter(
        (module, name)
        for modules in REASONS.values()
        for module, names in modules.items()
        if module != "about"
        for name in names
    )
    assert not written - set(listed), ADVICE
    assert not set(listed) - written, "no longer there: delete it from numbers_elsewhere.toml"
    assert max(listed.values()) == 1, "one reason is enough"
    assert all(modules["about"] for modules in REASONS.values())


def test_a_fraction_that_a_function_compares_with_has_a_name_or_is_listed() -> None:
    written = {
        module_of(path): compared
        for path in SOURCES
        if module_of(path).startswith(ENGINE) and (compared := fractions_compared(nodes_of(path)))
    }
    listed = {module: set(numbers) for module, numbers in LISTED["in_functions"].items()}
    assert written == listed, ADVICE
    reasons = {why for numbers in LISTED["in_functions"].values() for why in numbers.values()}
    assert reasons <= set(REASONS)


def test_no_constant_is_made_elsewhere() -> None:
    made = [
        module_of(path)
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "Constant"
    ]
    assert not made


@pytest.mark.parametrize("code", ["LEVEL = 0.3", "LEVEL: float = 2 * X", "A, LEVEL = 1, 2"])
def test_numbers_are_seen(code: str) -> None:
    assert "LEVEL" in set(names_with_numbers(ast.parse(code).body))


def test_what_is_no_number_is_not_seen() -> None:
    body = ast.parse("ON = True\nNAME = 'x'\ndef f():\n    y = 0.3").body
    assert not list(names_with_numbers(body))


def test_fractions_in_comparisons_are_seen() -> None:
    nodes = list(
        ast.walk(ast.parse("a > 1.0 + 3.0 * b\nc < 1e-9\nd == 0.5\ne = 0.7\nif 0.2 * x < y: pass"))
    )
    assert fractions_compared(nodes) == {"3.0", "0.2"}


def test_every_constant_says_what_it_is_and_how_it_was_chosen() -> None:
    known = [one for one in vars(constants).values() if isinstance(one, Constant)]
    assert known
    assert all(one.meaning and one.chosen for one in known)
