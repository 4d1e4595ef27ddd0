"""``bigant log repair``: a proper file of a cut or damaged log.

Everything that can be read goes into a new file with index and summary; the old file is not touched.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from record.log.salvage import Damage


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="new log (default: LOG.repaired.mcap beside it)"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Repair a log.

    Raises:
        RecordError: Nothing can be read, or the new file cannot be written.
    """
    from model.errors import RecordError
    from record.log.rewrite import repair
    from record.log.salvage import Pass
    from robot.console.progress import ProgressLine

    out: Path | None = options.out
    if out is None:
        out = options.path.with_suffix(".repaired.mcap")
        if out.exists():
            raise RecordError(f"{out} is there already; name another file with --out")
    progress = Pass()
    with ProgressLine(f"reading {options.path}", progress):
        done = repair(options.path, out, progress)
    print_damage(options.path, done.damages)
    print(f"{out}: {done.kept} messages")
    return ExitCode.OK


def print_damage(path: Path, damages: "tuple[Damage, ...]") -> None:
    """Say what could not be read, with times since the beginning of what is left."""
    from record.log.survey import survey_log

    if damages:
        start_ns = survey_log(path).start_unix_ns
        for damage in damages:
            print(f"{'lost' if damage.content else 'odd'}: {damage.words(start_ns)}")
