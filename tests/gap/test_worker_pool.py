"""Workers end with the program that started them, however it ends."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gap.worker_pool import worker_pool
from model.errors import GapError
from tests.soaked import soaked

BUSY = 600.0  # s; longer than any test may take
PATIENCE = 60.0  # s until a process that should be gone is called alive

PROGRAM = """
import os, sys, time
from pathlib import Path
from gap.worker_pool import worker_pool

def work(file):
    Path(file).write_text(str(os.getpid()))
    time.sleep({busy})

if __name__ == "__main__":
    with worker_pool(2, inherit={inherit}) as pool:
        for name in sys.argv[1:]:
            pool.submit(work, name)
        time.sleep({busy})
"""


def _is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def _wait(until: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < end, what
        time.sleep(0.02)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc to see processes")
@pytest.mark.parametrize("inherit", [False, True])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL, signal.SIGINT])
def test_no_worker_outlives_the_program(
    tmp_path: Path, number: signal.Signals, inherit: bool
) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM.format(busy=BUSY, inherit=inherit))
    files = [tmp_path / f"{i}.pid" for i in range(4)]
    running = subprocess.Popen(
        [sys.executable, str(program), *map(str, files)],
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
        # a shell's background jobs ignore SIGINT, and so would what this test starts from one
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        _wait(lambda: all(one.exists() and one.read_text() for one in files[:2]), "no worker began")
        pids = [int(one.read_text()) for one in files[:2]]
        running.send_signal(number)
        running.wait(PATIENCE)
        _wait(lambda: not any(map(_is_alive, pids)), "workers live on")
        assert not any(one.exists() for one in files[2:]), "what waited was still begun"
    finally:
        running.kill()
        running.communicate()


TALKERS = """
import sys, time
from pathlib import Path
from gap.worker_pool import worker_pool

def talk(file):
    Path(file).touch()
    return bytes(30_000_000)  # more than a pipe holds: somebody is always in the middle of it

if __name__ == "__main__":
    with worker_pool(2, inherit={inherit}) as pool:
        for _ in range(1000):
            pool.submit(talk, sys.argv[1])
        while not Path(sys.argv[1]).exists():
            time.sleep(0.001)
        time.sleep(float(sys.argv[2]))
        raise ZeroDivisionError
"""


@pytest.mark.parametrize("inherit", [False, True])
@pytest.mark.parametrize(
    "after_s", soaked([0.0, 0.02, 0.05, 0.1], lambda after_s: after_s in {0.0, 0.05})
)
def test_workers_that_are_sending_can_be_left(
    tmp_path: Path, after_s: float, inherit: bool
) -> None:
    program = tmp_path / "program.py"
    program.write_text(TALKERS.format(inherit=inherit))
    done = subprocess.run(
        [sys.executable, str(program), str(tmp_path / "begun"), str(after_s)],
        stderr=subprocess.PIPE, text=True, timeout=PATIENCE, check=False,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
    )  # fmt: skip
    assert "ZeroDivisionError" in done.stderr


def test_tasks_are_done_and_the_first_call_is_made_in_each_worker(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("BIGANT_TEST_INSTALLED", "no")
    with worker_pool(2, _install, inherit=True) as pool:
        assert list(pool.map(_told, range(4))) == ["yes"] * 4
    assert os.environ["BIGANT_TEST_INSTALLED"] == "no"
    with worker_pool(1) as pool:
        assert pool.submit(abs, -3).result() == 3


def _install() -> None:
    os.environ["BIGANT_TEST_INSTALLED"] = "yes"


def _told(_: int) -> str:
    return os.environ["BIGANT_TEST_INSTALLED"]


def test_an_exception_of_the_block_is_not_swallowed() -> None:
    def fail_inside() -> None:
        with worker_pool(1) as pool:
            pool.submit(time.sleep, BUSY)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_inside()


def test_no_process_at_all_is_refused() -> None:
    with pytest.raises(GapError, match="at least one"), worker_pool(0):
        pass
