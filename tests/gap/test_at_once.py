"""Several fits at a time give what one after the other gives, and fail as it does."""

import threading
import time

import pytest

from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from gap.residuals.at_once import ahead_of, each_of, meanwhile
from gap.residuals.pool import prediction_pool
from robot.console.json_output import json_text
from tests.gap.toy import Toy, toy_case, toy_references


@pytest.mark.parametrize("at_once", [1, 2, 3])
def test_answers_come_in_order_whatever_is_ready_first(at_once: int) -> None:
    def find(one: int) -> int:
        time.sleep(0.002 * (5 - one % 5))
        return one * one

    assert each_of(range(12), find, at_once) == [one * one for one in range(12)]
    assert list(ahead_of([], find, at_once)) == []


def test_an_error_comes_where_it_happened() -> None:
    def find(one: int) -> float:
        return 1.0 / (3 - one)

    answers = ahead_of(range(9), find, 2)
    assert [next(answers) for _ in range(3)] == [1 / 3, 1 / 2, 1.0]
    with pytest.raises(ZeroDivisionError):
        next(answers)


@pytest.mark.parametrize("at_once", [1, 2])
def test_what_is_found_meanwhile_is_found_once_and_fails_where_it_is_asked_for(
    at_once: int,
) -> None:
    threads: list[threading.Thread] = []

    def find() -> int:
        threads.append(threading.current_thread())
        return len(threads)

    answer = meanwhile(find, at_once)
    assert [answer(), answer()] == [1, 1]
    assert (threads[0] is threading.current_thread()) == (at_once == 1)
    wrong = meanwhile(lambda: 1 // 0, at_once)
    with pytest.raises(ZeroDivisionError):
        wrong()


def test_alone_nothing_is_found_that_nobody_asks_for() -> None:
    threads: list[int] = []
    meanwhile(lambda: threads.append(1), 1)
    assert not threads


def test_as_many_as_are_allowed_are_under_way_and_no_more() -> None:
    running, most, lock = 0, 0, threading.Lock()

    def find(one: int) -> int:
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.005)
        with lock:
            running -= 1
        return one

    each_of(range(8), find, 2)
    assert most == 2


def test_a_diagnosis_on_processes_is_that_of_this_one() -> None:
    trials, references = toy_case([Cause("stiffness", ("c",), (0.8,))], 3), toy_references(3)
    here = diagnose(trials, Toy(), references)
    with prediction_pool(Toy(), trials, references, 2) as pool:
        assert pool.at_once > 1
        there = diagnose(trials, Toy(), references, pool)
    assert [one.words for one in there.causes] == [one.words for one in here.causes]
    first, second = (json_text(diagnosis_json(one)) for one in (here, there))
    # how many predictions were made may differ: two threads may ask for the same one
    assert _without_count(first) == _without_count(second)


def _without_count(text: str) -> list[str]:
    return [line for line in text.splitlines() if '"predictions"' not in line]
