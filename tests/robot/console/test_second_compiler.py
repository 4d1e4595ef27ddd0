"""What is not compiled yet is compiled by two processes, and the second leaves with the first."""

import multiprocessing
import os
import subprocess
import sys
from typing import Any

import pytest

from bigant.compile_ahead import compile_ahead
from model.estimator import tolerance_kernel
from robot.console.second_compiler import MODULE, SecondCompiler

PATIENCE_S = 60.0


class Started:
    """Takes the place of a process."""

    def __init__(self, command: list[str], **_: Any) -> None:
        starts.append(command)


starts: list[list[str]] = []


@pytest.fixture(autouse=True)
def nothing_started(monkeypatch: pytest.MonkeyPatch) -> None:
    starts.clear()
    monkeypatch.setattr(subprocess, "Popen", Started)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: None)


def test_the_first_function_that_is_compiled_starts_it_and_no_later_one() -> None:
    second = SecondCompiler()
    second(False)
    assert not starts
    for begins in (True, True, False, False, True, False):
        second(begins)
    assert starts == [[sys.executable, "-P", "-m", MODULE]]


def test_one_processor_or_a_worker_compiles_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    SecondCompiler()(True)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: object())
    SecondCompiler()(True)
    assert not starts


def test_without_room_for_a_process_this_one_compiles_everything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise BlockingIOError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", full)
    second = SecondCompiler()
    second(True)
    assert second.process is None


def test_it_leaves_when_its_input_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    command = [sys.executable, "-P", "-m", MODULE]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, timeout=PATIENCE_S, check=False)
    assert done.returncode == 0


@pytest.mark.soak
def test_it_makes_the_kernels_of_a_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    compile_ahead()
    kernel: Any = tolerance_kernel.tolerance_kernel  # its types do not know of the compiler
    assert kernel.dispatcher().signatures
