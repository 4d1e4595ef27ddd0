"""Write HTML pages of all modules into site/ (``make docs``), the notebook interface with all its names."""

import warnings
from pathlib import Path

import pdoc
import pdoc.render

import bigant

SITE = Path(__file__).resolve().parents[1] / "site"
FOLDERS = ("bigant", "model", "gaits", "drivers", "record", "sim_hw", "gap", "robot")
LEFT_OUT = ("robot.view.rerun",)  # needs bigant[rerun], 640 MB
EXPECTED = (
    "Couldn't import robot.view.rerun",  # pdoc tries before it leaves it out
    r"Failed to run TYPE_CHECKING code while parsing type\[DataclassInstance\]",  # _typeshed is
    r"Error parsing type annotation type\[DataclassInstance\]",  # for type checkers only
)


def main() -> None:
    """Write the pages and print where they are."""
    names = dir(bigant)
    for name in names:
        getattr(bigant, name)  # loaded when first used; pdoc sees what is loaded
    bigant.__all__ = names  # type: ignore[attr-defined]
    for message in EXPECTED:
        warnings.filterwarnings("ignore", message)
    pdoc.render.configure(docformat="google", show_source=False)
    pdoc.pdoc(*FOLDERS, *(f"!{name}" for name in LEFT_OUT), output_directory=SITE)
    print(SITE / "index.html")


if __name__ == "__main__":
    main()
