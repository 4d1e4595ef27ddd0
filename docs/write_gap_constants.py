"""Write docs/gap_constants.md from ``gap.constants`` (``make docs``); with ``--check`` compare only."""

import sys
from pathlib import Path

from gap import constants
from gap.constants import Constant

PAGE = Path(__file__).resolve().parent / "gap_constants.md"
HEAD = """# Constants of the diagnosis

Every number that was set by hand and decides something in [the diagnosis](gap.md). Written by `make docs`
from `gap/constants.py`; do not edit. What follows from theory (degrees of freedom, quantiles) and what only
limits effort (how many candidates are fitted) is not here. What half and twice of each does to the figures
has not been measured yet.

| constant | value | meaning | chosen |
|---|---|---|---|
"""


def page() -> str:
    """Return the page."""
    rows = [
        f"| `{name}` | {float(value):g} | {value.meaning} | {value.chosen} |"
        for name, value in vars(constants).items()
        if isinstance(value, Constant)
    ]
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        sys.exit(0 if PAGE.read_text(encoding="utf-8") == page() else "run: make docs")
    PAGE.write_text(page(), encoding="utf-8")
