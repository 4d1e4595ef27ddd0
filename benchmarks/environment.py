"""What the runtime environment weighs, package by package, and what needs each of them.

``python -m benchmarks.environment`` follows the requirements of the installed ``bigant`` without its extras
and adds up the files of every distribution, compiled ones included, tests' and development's tools not.
"""

import re
from collections.abc import Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement

PRODUCT = "bigant"
MEGABYTE = 1e6
SMALL = 0.5  # megabytes; what is smaller is added up in one row


def needed(name: str = PRODUCT) -> dict[str, set[str]]:
    """Return every distribution that one needs, itself left out, with those that ask for it."""
    asked_by: dict[str, set[str]] = {}
    left = [name]
    while left:
        asking = left.pop()
        for one in requirements(distribution(asking)):
            if one not in asked_by:
                left.append(one)
            asked_by.setdefault(one, set()).add(asking)
    return asked_by


def requirements(of: Distribution) -> Iterator[str]:
    """Return the names of what a distribution needs on this machine without extras."""
    for text in of.requires or ():
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield re.sub(r"[-_.]+", "-", requirement.name).lower()


def size_mb(name: str) -> float:
    """Return what the files of a distribution take, compiled Python included [MB]."""
    files = {Path(str(file.locate())) for file in distribution(name).files or ()}
    folders = {file.parent / "__pycache__" for file in files if file.suffix == ".py"}
    compiled = {one for folder in folders if folder.is_dir() for one in folder.iterdir()}
    return sum(file.stat().st_size for file in files | compiled if file.is_file()) / MEGABYTE


def main() -> None:
    """Print the table."""
    asked_by = needed()
    sizes = sorted(((size_mb(name), name) for name in asked_by), reverse=True)
    print("package | MB | needed by\n---|---|---")
    for size, name in sizes:
        if size >= SMALL:
            print(f"{name} | {size:.0f} | {', '.join(sorted(asked_by[name]))}")
    rest = [size for size, _ in sizes if size < SMALL]
    print(f"{len(rest)} others | {sum(rest):.0f} |")
    print(f"all | {sum(size for size, _ in sizes):.0f} |")


if __name__ == "__main__":
    main()
