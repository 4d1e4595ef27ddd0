"""Whether the names of our packages are ours here: ``model.py`` beside a notebook has one of them, too.

Imports nothing of ours, because whatever it imported might be somebody else's.
"""

import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("robot", "model", "gaits", "drivers", "record", "sim_hw", "gap")
HOME = Path(__file__).resolve().parent.parent  # what holds all of them
WORDS_ONLY = {"__doc__"}  # all that the __init__.py of one of ours sets


class NameConflict(ImportError):  # noqa: N818 - it says what happened
    """A module of somebody else has the name of one of our packages.

    Attributes:
        name: The name.
        path: Their file, empty if it is not known.
    """


def check_names() -> None:
    """Make sure that every package of ours is the one that an import gets; imports none of them.

    Raises:
        NameConflict: One is not; the message is one sentence that says which file, and what to do.
    """
    for name in PACKAGES:
        if words := _conflict(name):
            raise NameConflict(f"{words[0]}; {words[1]}", name=name, path=words[2])


def leave_folder_out() -> None:
    """Take the current folder off the path: ``python -m bigant`` has it first, ``bigant`` has not."""
    if sys.flags.safe_path or not sys.path:
        return
    first = Path(sys.path[0]).resolve()
    if first == Path.cwd() and first != HOME:
        del sys.path[0]


def _conflict(name: str) -> tuple[str, str, str] | None:
    """What is wrong with a name, what to do, and the file; None if it is ours."""
    try:
        spec = find_spec(name)
    except ValueError:  # an imported module without a spec: made by hand
        spec = None
    own = HOME / name / "__init__.py"
    file = Path(spec.origin).resolve() if spec is not None and spec.origin is not None else None
    if file == own:
        if not _runs_code(own):
            return None
        others = " and ".join(_owners(own)) or "another distribution"
        return (
            f"{own} of BigANT was overwritten by {others}",
            f"install BigANT into an environment without it: both have a package {name!r}",
            str(own),
        )
    if not own.is_file():
        return (
            f"the package {name!r} of BigANT has lost its __init__.py in {own.parent}",
            "install BigANT again: pip install --force-reinstall --no-deps",
            "",
        )
    if file is None:
        where = f"the module {name!r} is not BigANT's" if spec is None else f"{name!r} is a folder"
        return where, f"BigANT needs its own package of that name, {own.parent}", ""
    others = " and ".join(_owners(file))
    words = f"{file}" + (f" of the distribution {others}" if others else "")
    words += f" has the name of BigANT's package {name!r}"
    if name in sys.modules:
        words += " and is imported already"
    if others:
        return words, "install BigANT into an environment without it", str(file)
    return words, "rename it, or start Python in another folder", str(file)


def _runs_code(file: Path) -> bool:
    """Whether a module does anything but hold words."""
    try:
        code = compile(file.read_bytes(), str(file), "exec")
    except (OSError, SyntaxError, ValueError):
        return True
    return not set(code.co_names) <= WORDS_ONLY


def _owners(file: Path) -> Iterator[str]:
    """Yield the distributions other than ours that have a file in their records."""
    from importlib.metadata import distributions  # takes 20 ms, which only a conflict is worth

    for one in distributions():
        name = one.metadata["Name"] or ""
        if name != "bigant" and any(
            Path(str(one.locate_file(record))).resolve() == file
            for record in one.files or ()
            if record.name == file.name
        ):
            yield name
