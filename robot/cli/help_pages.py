"""Which page of docs/ helps with which mistake; every one-line error ends with it."""

import re

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
from robot.console.shipped import ROBOT_FILE_PAGE

# The first that fits; a page that does not exist fails a test.
PAGES: tuple[tuple[type[BigantError], str], ...] = (
    (BusError, "docs/tutorial.md#wiring"),
    (ForceStreamError, "docs/tutorial.md#force-torque-network"),
    (GaitRefused, "docs/gaits.md"),
    (RecordError, "docs/log.md"),
    (GapError, "docs/gap_effects.md"),
    (ModelError, "docs/model.md"),
)
# A key of a table, with its file before it or not: legs.servo_zero, lab.toml: servo_bus.ids[2].
KEY = re.compile(r"(?:.*: )?[a-z_]+(\.[A-Za-z_]+)+(\[\d+\])*")
FILE_ENDS = (".toml", ".mcap", ".json", ".parquet")


def page_of(error: BigantError) -> str:
    """Return the page that helps, empty where the error itself says all there is."""
    if isinstance(error, ConfigError):
        if error.page:
            return error.page
        # an option's mistake is explained by the option's help; a key's by the page on the file
        own = KEY.fullmatch(error.key) and not error.key.endswith(FILE_ENDS)
        return ROBOT_FILE_PAGE if own or "robot file" in error.reason else ""
    return next((page for kind, page in PAGES if isinstance(error, kind)), "")


def page_hint(error: BigantError) -> str:
    """Return what is added to the error's line."""
    page = page_of(error)
    return f" (see {page})" if page and "see docs/" not in str(error) else ""
