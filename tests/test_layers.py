"""What holds for the whole tree: import contracts, names, hosts, paths, modules of one idea."""

import ast
import re
import subprocess
from collections.abc import Iterator, Mapping, Set
from graphlib import TopologicalSorter
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from tests.source_trees import nodes_of, tree_of

ROOT = Path(__file__).resolve().parents[1]
OURS = ("bigant", "robot", "model", "gaits", "drivers", "record", "sim_hw", "gap")
SOURCES = sorted(p for folder in OURS for p in (ROOT / folder).rglob("*.py"))


def tracked_texts() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    paths = [ROOT / line for line in listed.stdout.splitlines()]
    return [p for p in paths if p.suffix not in {".png", ".mcap"} and p.is_file()]


def test_no_installed_package_uses_our_names() -> None:
    providers = packages_distributions()
    others = {name: set(providers.get(name, ())) - {"bigant"} for name in OURS}
    assert not {name: found for name, found in others.items() if found}


ROOMS = sorted({path.parent for path in SOURCES})


def test_a_module_holds_one_idea() -> None:
    lines = {_place(one): len(one.read_text(encoding="utf-8").splitlines()) for one in SOURCES}
    assert not {name: count for name, count in lines.items() if count > 450}, "is it one idea?"
    vague = re.compile(r"(utils?|helpers?|common|misc|manager)")
    assert not [_place(one) for one in SOURCES if vague.match(one.stem)]


def _place(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


KERNELS = {"compiled", "compiled_sums"}  # machine code takes plain arrays and numbers
MOST_PARAMETERS = 7


def test_values_that_travel_together_are_one_value() -> None:
    long = {
        f"{_place(path)}: {name}": count
        for path in SOURCES
        for name, count in _parameters(path)
        if count > MOST_PARAMETERS
    }
    assert not long, "give what travels together a name: a dataclass or a named tuple"


def _parameters(path: Path) -> Iterator[tuple[str, int]]:
    """Functions of a module that are no kernels, and how many parameters each has besides ``self``."""
    for node in nodes_of(path):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        names = [
            one.arg for one in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
        ]
        decorators = {ast.unparse(one).split("(")[0] for one in node.decorator_list}
        if not decorators & KERNELS:
            yield node.name, len(names) - (names[:1] in (["self"], ["cls"]))


def test_nothing_names_a_package_index_or_a_place_of_some_machine() -> None:
    # built from pieces, so that this file does not match itself
    index = re.compile("index" + r"[-_]url\s*=|pypi\." + "org|python" + "hosted|/sim" + "ple/")
    place = re.compile(r"(^|[\s\"'=(])/(ro" + "ot|wo" + "rk|ho" + r"me/\w+)/")
    for path in tracked_texts():
        text = path.read_text(encoding="utf-8", errors="ignore")
        assert not index.search(text), path
        assert not place.search(text), path


def test_nothing_is_pickled_into_logs() -> None:
    # what processes of one command hand to each other, and what they delete at once, is no log
    handed_over = ROOT / "robot" / "console" / "stretch_pool.py"
    for path in set(SOURCES) - {handed_over}:
        assert "import pickle" not in path.read_text(encoding="utf-8"), path


def test_only_the_loop_waits() -> None:
    """No sleep outside the clock: real-time behaviour can be tested in virtual time."""
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        if path.relative_to(ROOT).as_posix() == "drivers/clock.py":
            continue
        assert "time.sleep" not in text, path


def test_a_room_can_be_taken_in_at_a_glance_and_says_what_lives_there() -> None:
    modules = {_place(room): len(list(room.glob("*.py"))) for room in ROOMS}
    full = {room: count for room, count in modules.items() if count > 26}
    assert not full, "make a folder of what belongs together"
    doors = {_place(room): ast.get_docstring(tree_of(room / "__init__.py")) or "" for room in ROOMS}
    silent = [room for room, words in doors.items() if len(words.splitlines()) < 3]
    assert not silent, "what lives here, who calls"


def test_the_first_floor_of_robot_is_folders() -> None:
    assert len([path for path in (ROOT / "robot").iterdir() if path.is_file()]) <= 5


def test_modules_and_rooms_import_each_other_without_circles() -> None:
    """A folder above and its own rooms are one: what is at the top of it serves them all."""
    names = {_name(path): path for path in SOURCES}
    graph = {name: _imports(path, names.keys() - {name}) for name, path in names.items()}
    TopologicalSorter(graph).prepare()  # raises CycleError and names the circle
    of_rooms: dict[str, set[str]] = {}
    for name, imported in graph.items():
        room = _name(names[name].parent)
        of_rooms.setdefault(room, set()).update(
            {_room(other, names) for other in imported} - {room}
        )
    TopologicalSorter(of_rooms).prepare()


def _name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def _room(name: str, names: Mapping[str, Path]) -> str:
    return _name(names[name].parent)


def _imports(path: Path, known: Set[str]) -> set[str]:
    """Modules of ours that a module imports anywhere: at its top, in functions, and for types only."""
    found = set()
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.add(inner if inner in known else node.module)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found & known
