"""Files that come with the program: robot files, examples, pages; and where they are on this computer.

In a clone they lie beside the packages (``config/``, ``examples/``, ``docs/``); a wheel holds copies of the
same files in ``robot/shipped/``, made when it is built (``pyproject.toml``).
"""

import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent  # robot/
INSTALLED = (PACKAGE / "shipped").is_dir()  # from a wheel; otherwise this is a clone
HOME = PACKAGE / "shipped" if INSTALLED else PACKAGE.parent
ROBOT_FILE_PAGE = "docs/tutorial.md#your-robots-file"  # for a mistake in a robot file
PAGE = re.compile(r"\bdocs/\w+\.md\b")


def shipped(name: str) -> Path:
    """Return where a file or folder of the project is, for example ``config/bigant.toml``."""
    return HOME / name


def with_pages(text: str) -> str:
    """Return a text whose pages (``docs/log.md``) can be opened from anywhere.

    In a clone they are left as they are: the reader stands in it, or knows where it is.
    """
    return PAGE.sub(lambda page: str(shipped(page[0])), text) if INSTALLED else text
