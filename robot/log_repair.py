"""``bigant log repair``: a proper file of a cut or damaged log.

Everything that can be read goes into a new file with index and summary; the old file is not touched.
"""

import argparse
from pathlib import Path

from robot.exit_codes import ExitCode


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
    from record.recover import repair
    from record.salvage import Pass
    from robot.progress import ProgressLine

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


def print_damage(path: Path, damages: object) -> None:
    """Say what could not be read, with times since the beginning of what is left."""
    from record.salvage import Damage
    from record.survey import survey_log

    found = [d for d in damages if isinstance(d, Damage)] if isinstance(damages, tuple) else []
    if not found:
        return
    start_ns = survey_log(path).start_unix_ns
    for damage in found:
        begin = f"{(damage.from_ns - start_ns) * 1e-9:.2f} s" if damage.from_ns >= 0 else "?"
        end = f"{(damage.to_ns - start_ns) * 1e-9:.2f} s" if damage.to_ns >= 0 else "the end"
        size = f"{damage.size} bytes" if damage.size else "everything"
        print(f"lost: {size} from byte {damage.offset}, {begin} to {end}: {damage.reason}")
