"""Write docs/reference/modules.md from the modules' docstrings (``make docs``)."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "modules.md"
FOLDERS = (
    "model",
    "gaits",
    "drivers",
    "record",
    "sim_hw",
    "gap",
    "robot",
    "bigant",
)  # as imports point, last first
HEAD = """# Modules

Written by `make docs` from the first line of each module's docstring; do not edit. The idea of each
folder, and which modules matter most: [how it is built](../architecture.md).
"""


def page() -> str:
    """Return the page."""
    parts = [HEAD]
    for folder in FOLDERS:
        doors = sorted((ROOT / folder).rglob("__init__.py"))
        for door in doors:
            parts += [f"{'##' if door.parent.name == folder else '###'} {_name(door.parent)}\n"]
            parts += [f"{about}\n" for about in [_idea(door)] if about]
            rows = [(_name(file), _idea(file)) for file in sorted(door.parent.glob("*.py"))]
            rows = [(name, idea) for name, idea in rows if not name.endswith("__init__")]
            if rows:
                parts += ["| module | its idea |", "|---|---|"]
                parts += [f"| `{name}` | {idea} |" for name, idea in rows]
                parts.append("")
    return "\n".join(parts)


def _name(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts)


def _idea(file: Path) -> str:
    """Return the first line of a module's docstring as Markdown; empty without one."""
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    line = text.partition("\n")[0].replace("``", "`")
    pieces = line.split("`")  # even ones are words, odd ones code
    return "`".join(one if i % 2 else _plain(one) for i, one in enumerate(pieces)).replace(
        "|", "\\|"
    )


def _plain(text: str) -> str:
    """Text that Markdown leaves alone."""
    for mark in ("*", "<", "_"):
        text = text.replace(mark, f"\\{mark}")
    return text


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
