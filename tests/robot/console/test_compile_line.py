"""A first run says that it compiles; a tick never does."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from model.compiled import compiles
from robot.config.robot_file import load_robot
from robot.console.progress import LABEL, CompileLine
from robot.control.controller import Controller

ROOT = Path(__file__).resolve().parents[3]
# The smallest kernel there is, in a process that has never compiled it and no patience at all.
FIRST_RUN = """
import sys
from robot.console import progress
from robot.console.progress import show_compiling
progress.FIRST_S = 0.0
show_compiling()
import numpy as np
from model.motion.differentiate import latest_rate
print(latest_rate(np.arange(3), np.zeros((3, 1)))[0] == 0)
"""

pytestmark = pytest.mark.skipif(not compiles(), reason="numba is not there")


def _run(cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", FIRST_RUN],
        cwd=ROOT,
        env={"NUMBA_CACHE_DIR": str(cache), "PATH": "", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.soak
def test_a_first_run_says_so_and_a_second_is_silent(tmp_path: Path) -> None:
    first, second = _run(tmp_path), _run(tmp_path)
    assert first.stdout == second.stdout == "True\n"
    assert first.stderr.startswith(LABEL)
    assert second.stderr == ""


def test_it_counts_functions_and_is_silent_in_the_first_second(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    line = CompileLine()
    line(True)
    line(False)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("robot.console.progress.FIRST_S", 0.0)
    line = CompileLine()
    for begins in (True, True, False, True):
        line(begins)
    assert f"{LABEL}: 0 functions done" in capsys.readouterr().err


def test_no_tick_can_wait_for_the_compiler() -> None:
    from model.estimator import frame_kernel as estimator_kernel
    from model.estimator import gate_kernel, measurements, process, report, stride
    from model.kinematics import four_bar as linkage
    from model.quasistatic import frame as quasistatic

    Controller(load_robot(), (), armed=False)
    called: list[Any] = [
        quasistatic.frame_kernel, linkage.feet_kernel, estimator_kernel.neighbourhood_kernel,
        process.walk_kernel, process.carry_kernel,
        measurements.feet_stack_kernel, stride.stride_kernel, gate_kernel.weigh_kernel,
        report.report_kernel,
    ]  # fmt: skip
    for kernel in called:
        assert kernel.dispatcher().signatures, kernel
        assert not kernel.dispatcher()._can_compile, kernel
