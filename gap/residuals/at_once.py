"""Several things at a time: while one waits for predictions, another works on those that it has."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Question = TypeVar("Question")
Answer = TypeVar("Answer")


def each_of(
    asked: Sequence[Question], find: Callable[[Question], Answer], at_once: int
) -> list[Answer]:
    """Return what is found for each, in order, with so many threads; 1 uses none."""
    return list(ahead_of(asked, find, at_once if len(asked) > 1 else 1))


def ahead_of(
    asked: Sequence[Question], find: Callable[[Question], Answer], at_once: int
) -> Iterator[Answer]:
    """Yield what is found for each, in order; so many of the next ones are under way meanwhile."""
    if at_once == 1:
        yield from map(find, asked)
        return
    with ThreadPoolExecutor(at_once) as threads:
        coming: deque[Future[Answer]] = deque()
        for one in asked:
            coming.append(threads.submit(find, one))
            if len(coming) > at_once:
                yield coming.popleft().result()
        while coming:
            yield coming.popleft().result()


def meanwhile(find: Callable[[], Answer], at_once: int) -> Callable[[], Answer]:
    """Begin to find something that takes no predictions, and return what to call for the answer.

    A thread of its own finds it while others wait for predictions. Where nothing is done at once
    (1), it is found when it is first asked for.
    """
    if at_once == 1:
        return cache(find)
    thread = ThreadPoolExecutor(1)
    coming = thread.submit(find)
    thread.shutdown(wait=False)  # nothing more is asked of it
    return coming.result
