"""The estimator of a long log, replayed in a process of its own beside the one that replays the controller.

No command depends on the estimate. So the two can be compared with the log apart: the controller from the
recorded inputs, the estimator from what the log says was sensed. If both are the same in every bit, what
was sensed is what the controller senses today, and together they are the replay of the whole. If anything
differs, nothing is concluded from it: the log is then replayed tick by tick.
"""

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path

from gap.worker_pool import worker_pool
from model.errors import ConfigError, RecordError
from record.log.blocks.sensed_columns import sensed_messages
from record.log.blocks.tick_forms import FormBook
from record.log.reader import LogContents, read_tick_messages
from record.log.salvage import DAMAGE
from record.log.tick_message import decode_tick, estimates_the_same
from robot.config.robot_file import RobotConfig
from robot.control.tick_estimator import TickEstimator

BLOCK_TICKS = 256


@contextmanager
def estimator_beside(path: Path, config: RobotConfig) -> Iterator[Future[int]]:
    """Replay the estimator in another process; the result is that of ``estimates_as_recorded``."""
    with worker_pool(1) as pool:
        yield pool.submit(estimates_as_recorded, path, config)


def estimates_as_recorded(path: Path, config: RobotConfig) -> int:
    """Return how many ticks of a log, from the first on, have the recorded estimate in every bit.

    Args:
        path: A log of today's layout.
        config: The robot that the estimator uses.

    What cannot be read ends them: the process that replays the controller says what is wrong with it.
    """
    contents, estimator, book = LogContents(), TickEstimator(config), FormBook()
    messages = (message.data for message in read_tick_messages(path, contents))
    count = 0
    with suppress(RecordError, ConfigError, *DAMAGE):
        while block := list(islice(messages, BLOCK_TICKS)):
            machine = contents.machine(decode_tick(block[0]))
            numbers, begins, ticks = sensed_messages(block, machine, book)
            for k, data in enumerate(block):
                estimate = estimator.step(ticks.tick(k))
                if numbers[k] != count or not estimates_the_same(estimate, data, begins[k]):
                    return count
                count += 1
    return count
