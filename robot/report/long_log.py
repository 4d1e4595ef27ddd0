"""Reading a log of any length for its summary and pictures, in bounded memory."""

from dataclasses import replace
from pathlib import Path

from record.log.reader import LogContents, read_blocks
from record.log.recording import Recording, join_recordings, thin_recording
from robot.console.progress import ProgressLine
from robot.control.effect_uses import TrueForces, true_forces_of_log
from robot.report.run_totals import RunTotals
from robot.report.summary import Summary, summarise_totals

# Five minutes at 100 Hz are kept whole; of a longer log every second, fourth, ... tick is drawn.
DRAWN_TICKS = 30_000


def read_summary(path: Path) -> tuple[Summary, Recording]:
    """Return the figures of all of a log, and as much of it as pictures need.

    Forces are as the log's robot file has them: without what its effects say the sensors add.

    Raises:
        RecordError: The log cannot be read.
    """
    contents = LogContents()
    totals = RunTotals()
    kept: list[Recording] = []
    step, count = 1, 0
    true_forces: TrueForces | None = None
    with ProgressLine(f"reading {path}", contents.progress):
        for measured in read_blocks(path, contents):
            if count == 0:  # the robot file comes before the first tick
                true_forces = true_forces_of_log(measured.config_text)
            block = measured
            if true_forces is not None:
                block = replace(measured, force_n=true_forces(measured.force_n, measured.t_s))
            totals.add(block)
            kept.append(thin_recording(block, step))
            count += len(kept[-1].t_s)
            if count > DRAWN_TICKS:
                step *= 2
                kept = [thin_recording(join_recordings(kept, ""), 2)]
                count = len(kept[0].t_s)
    log = join_recordings(kept, contents.damage)
    return summarise_totals(totals, replace(block, damage=contents.damage)), log
