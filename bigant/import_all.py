"""``python -m bigant.import_all``: import every module of ours, for ``make install``.

Python keeps compiled copies of what it imports. So no start has to compile them, and the thousands of
modules of other packages that nothing imports are never compiled, which takes pip longer than all else.
"""

import importlib
import pkgutil
import sys

FOLDERS = ("model", "gaits", "record", "drivers", "sim_hw", "gap", "robot", "bigant")
RUN_WHEN_IMPORTED = ("__main__", "compile_ahead", "import_all")


def import_all() -> int:
    """Import them and return how many there are."""
    sys.dont_write_bytecode = False  # set in many containers, where every start would compile again
    count = 0
    for folder in FOLDERS:
        package = importlib.import_module(folder)
        for one in pkgutil.walk_packages(package.__path__, f"{folder}."):
            if one.name.rpartition(".")[2] not in RUN_WHEN_IMPORTED:
                count += _imported(one.name)
    return count


def _imported(name: str) -> bool:
    """Import a module, unless it needs an extra that is not installed."""
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] in FOLDERS:
            raise
        return False
    return True


if __name__ == "__main__":
    import_all()
