"""``python -m bigant.import_all``: import every module of ours, for ``make install``.

Python keeps compiled copies of what it imports. So no start has to compile them, and the thousands of
modules of other packages that nothing imports are never compiled, which takes pip longer than all else.
"""

import importlib
import pkgutil
import sys

FOLDERS = ("model", "gaits", "record", "drivers", "sim_hw", "gap", "robot", "bigant")


def import_all() -> None:
    """Import them, but what needs an extra that is not installed."""
    for folder in FOLDERS:
        package = importlib.import_module(folder)
        for one in pkgutil.walk_packages(package.__path__, f"{folder}."):
            try:
                importlib.import_module(one.name)
            except ModuleNotFoundError as error:
                if (error.name or "").partition(".")[0] in FOLDERS:
                    raise


if __name__ == "__main__":
    sys.dont_write_bytecode = False  # set in many containers, where every start would compile again
    import_all()
