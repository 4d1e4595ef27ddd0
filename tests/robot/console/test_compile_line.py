"""A first run says that it compiles; a tick never does."""

import subprocess
import sys
from pathlib import Path

import pytest

from model.compiled import COMPILED
from robot.config.robot_file import load_robot
from robot.console.compile_line import LABEL, CompileLine
from robot.control.controller import Controller

ROOT = Path(__file__).resolve().parents[3]
# The smallest kernel there is, in a process that has never compiled it and no patience at all.
FIRST_RUN = """
import sys
from robot import progress
from robot.console.compile_line import show_compiling
progress.FIRST_S = 0.0
show_compiling()
import numpy as np
from model.estimator.step_kernel import sound_kernel
print(sound_kernel(np.eye(3)))
"""

pytestmark = pytest.mark.skipif(not COMPILED, reason="numba is not there")


def _run(cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", FIRST_RUN],
        cwd=ROOT,
        env={"NUMBA_CACHE_DIR": str(cache), "PATH": "", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )


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
    from model.estimator import (
        frame_kernel as estimator_kernel,
    )
    from model.estimator import (
        readout_kernel as estimator_readout_kernel,
    )
    from model.estimator import (
        step_kernel as estimator_step_kernel,
    )
    from model.estimator import (
        update_kernel as estimator_update_kernel,
    )
    from model.kinematics import four_bar as linkage
    from model.quasistatic import frame as quasistatic

    Controller(load_robot(), (), armed=False)
    called = [
        quasistatic.frame_kernel, linkage.feet_kernel, estimator_kernel.neighbourhood_kernel,
        *(getattr(estimator_step_kernel, name) for name in (
            "slopes_kernel", "walk_kernel", "carry_kernel", "sound_kernel",
        )),
        estimator_update_kernel.predict_kernel, estimator_update_kernel.update_kernel,
        estimator_readout_kernel.readout_kernel,
    ]  # fmt: skip
    for kernel in called:
        assert kernel.signatures, kernel
        assert not kernel._can_compile, kernel
