"""What names may not be: a class name that means two things, a word that does not say what a value is."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.source_trees import nodes_of, tree_of

ROOT = Path(__file__).resolve().parents[1]
OURS = ("bigant", "robot", "model", "gaits", "drivers", "record", "sim_hw", "gap")
SOURCES = sorted(p for folder in OURS for p in (ROOT / folder).rglob("*.py"))

VAGUE = frozenset({"found", "said", "told", "truly", "way", "ways", "whence"})
VAGUE_CLASSES = VAGUE | {"seen"}
WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")

# Fields that a command writes as keys of its JSON.
FORMATS = {
    ("gap/check", "said"),
    ("robot/bringup/first_day", "found"),
    ("robot/bringup/mapping", "found"),
    ("robot/bringup/preflight", "found"),
    ("robot/campaign", "said"),
    ("robot/replay", "new_reckoned_way"),
    ("robot/replay", "new_way"),
    ("robot/replay", "old_reckoned_way"),
    ("robot/replay", "old_way"),
}
FOREIGN = {"FileNotFoundError", "ModuleNotFoundError", "PackageNotFoundError"}


def identifiers(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Every name in a module: of variables, attributes, arguments, functions, classes and imports."""
    for node in nodes:
        if isinstance(node, ast.Constant):
            continue
        for _, value in ast.iter_fields(node):
            for one in value if isinstance(value, list) else [value]:
                if isinstance(one, str):
                    yield one


def words_of(name: str) -> set[str]:
    return {word.lower() for word in WORD.findall(name)}


def vague_names(path: Path) -> set[str]:
    nodes = nodes_of(path)
    classes = {one.name for one in nodes if isinstance(one, ast.ClassDef)}
    vague = {name for name in identifiers(nodes) if words_of(name) & VAGUE}
    return (vague | {name for name in classes if words_of(name) & VAGUE_CLASSES}) - FOREIGN


def test_a_name_says_what_a_value_is() -> None:
    vague = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in SOURCES
        for name in vague_names(path)
        if (path.parent.relative_to(ROOT).as_posix(), name) not in FORMATS
    }
    assert not vague, "say what it is: result, settings, diagnosis, track, displacement, source"


def test_a_public_class_name_means_one_thing() -> None:
    places: dict[str, list[str]] = defaultdict(list)
    for path in SOURCES:
        for node in tree_of(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(path.relative_to(ROOT).as_posix())
    twice = {name: where for name, where in places.items() if len(where) > 1}
    assert not twice, "give the narrower one a qualifying word"


def test_the_words_of_a_name() -> None:
    assert words_of("WAY_COLOURS") == {"way", "colours"}
    assert words_of("ReadTold") == {"read", "told"}
    assert words_of("_half_way2") == {"half", "way"}
    assert words_of("always_founded") == {"always", "founded"}
    tree = ast.parse("import a.b as found\ndef f(way=1):\n    x.told = 'said'")
    names = set(identifiers(ast.walk(tree)))
    assert names == {"a.b", "found", "f", "way", "x", "told"}
