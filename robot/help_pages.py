"""Which page of docs/ helps with which mistake; every one-line error ends with it."""

from model.errors import (
    BigantError,
    BusError,
    ConfigError,
    ForceStreamError,
    GaitRefused,
    GapError,
    ModelError,
    RecordError,
)

# The first that fits; a page that does not exist fails a test.
PAGES: tuple[tuple[type[BigantError], str], ...] = (
    (BusError, "docs/tutorial.md#wiring"),
    (ForceStreamError, "docs/tutorial.md#force-torque-network"),
    (GaitRefused, "docs/gaits.md"),
    (RecordError, "docs/log.md"),
    (GapError, "docs/gap_effects.md"),
    (ModelError, "docs/model.md"),
)
ROBOT_FILE_PAGE = "docs/tutorial.md#your-robots-file"


def page_of(error: BigantError) -> str:
    """Return the page that helps, empty where the error itself says all there is."""
    if isinstance(error, ConfigError):
        # an option's mistake is explained by the option's help; a key's by the page on the file
        return ROBOT_FILE_PAGE if "." in error.key and not error.key.startswith("-") else ""
    return next((page for kind, page in PAGES if isinstance(error, kind)), "")


def page_hint(error: BigantError) -> str:
    """Return what is added to the error's line."""
    page = page_of(error)
    return f" (see {page})" if page and "see docs/" not in str(error) else ""
