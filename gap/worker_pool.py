"""Worker processes that never outlive the command that started them.

``concurrent.futures`` alone leaves its workers behind when the program is killed, and works off all that
waits when it is interrupted. Here Ctrl-C is the program's affair, and a worker leaves at once when the
program is gone or gives the pool up.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from typing import Any

from model.errors import GapError

ABANDONED = 1  # exit code of a worker whose pool was given up


@contextmanager
def worker_pool(
    count: int, install: Callable[[], None] | None = None, *, inherit: bool = False
) -> Iterator[ProcessPoolExecutor]:
    """Start processes, and end them: when all is done, or at once when the block is left by an exception.

    Args:
        count: Number of processes.
        install: Called once in every worker before its first task.
        inherit: Fork, so that what ``install`` holds need not be pickled; else fresh interpreters, because
            compiled code and threads of this process are not to be forked.

    Raises:
        GapError: ``count`` is not positive.
    """
    if count < 1:
        raise GapError(f"at least one worker process is needed, not {count}")
    context = multiprocessing.get_context("fork" if inherit else "spawn")
    receiver, sender = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        count,
        mp_context=context,
        initializer=_begin,
        initargs=(receiver, sender if inherit else None, install),
    )
    try:
        yield pool
    except BaseException:
        sender.close()  # end of file: workers leave in the middle of what they do
        _end_of_results(pool)
        pool.shutdown(cancel_futures=True)
        raise
    finally:
        pool.shutdown()
        sender.close()
        receiver.close()


def _end_of_results(pool: ProcessPoolExecutor) -> None:
    """Let the pool's own thread see that nothing more comes, or it waits for the rest of a broken message.

    A worker may leave in the middle of sending a result. The pipe then ends only if no process can write
    into it any more, and this one, which never does, still could.
    """
    results: Any = pool._result_queue
    if results is not None:
        results._writer.close()


def _begin(
    receiver: Connection, sender: Connection | None, install: Callable[[], None] | None
) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP):  # a fork has the program's own handlers
        signal.signal(number, signal.SIG_DFL)
    if sender is not None:
        sender.close()  # a fork's own copy would keep the pipe open
    threading.Thread(target=_leave_with_parent, args=(receiver,), daemon=True).start()
    if install is not None:
        install()


def _leave_with_parent(receiver: Connection) -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # only workers come here
    wait([receiver, parent.sentinel])
    os._exit(ABANDONED)
