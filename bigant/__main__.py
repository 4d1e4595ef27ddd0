"""``bigant`` and ``python -m bigant``: where the command starts."""

import sys
from typing import NoReturn

from bigant.name_conflict import NameConflict, check_names, leave_folder_out
from bigant.one_thread import one_thread

WRONG_USAGE = 2  # ExitCode.USAGE, which cannot be imported before the names are known to be ours


def main() -> NoReturn:
    """Run the command line and exit.

    Raises:
        SystemExit: Always.
    """
    leave_folder_out()
    try:
        check_names()
    except NameConflict as conflict:
        print(f"bigant: {conflict}", file=sys.stderr)
        raise SystemExit(WRONG_USAGE) from None
    one_thread()
    from robot.cli import main as command

    command.main()


if __name__ == "__main__":
    main()
