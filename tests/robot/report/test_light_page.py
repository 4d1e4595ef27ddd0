"""The page of a log is made without the compiler and without what draws films: both take much memory."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from model.compiled import compiles
from model.kinematics.legs import leg_kinematics
from robot.config.robot_file import load_robot
from robot.report.page import REPLAY
from tests.replay.golden import log_of

ROOT = Path(__file__).resolve().parents[3]
PAGE = """
import sys
from bigant.__main__ import main
try:
    main()
finally:
    print("loaded", *{"numba", "scipy.spatial", "robot.view.film"} & sys.modules.keys())
"""
FEET = """
import sys
import numpy as np
from model.compiled import few_calls
from model.kinematics.legs import leg_kinematics
from robot.config.robot_file import load_robot
angles = np.random.default_rng(1).uniform(-4.0, 4.0, (50, 6))
legs = leg_kinematics(load_robot().parameters)
with few_calls():
    few = legs.feet(angles, np.ones_like(angles))
    assert "numba" not in sys.modules
after = legs.feet(angles, np.ones_like(angles))
assert "numba" in sys.modules
np.savez(sys.argv[1], few=few.position_m, speed=few.velocity_m_s, after=after.position_m)
"""


@pytest.mark.soak
def test_show_loads_neither(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    told = subprocess.run(
        [sys.executable, "-c", PAGE, "show", str(log_of("tripod")), "--out", str(page)],
        cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout.splitlines()  # fmt: skip
    assert told[-1] == "loaded"
    assert REPLAY in page.read_text(encoding="utf-8")


@pytest.mark.skipif(not compiles(), reason="numba is not there")
def test_few_calls_give_what_machine_code_gives(tmp_path: Path) -> None:
    path = tmp_path / "feet.npz"
    subprocess.run([sys.executable, "-c", FEET, str(path)], cwd=ROOT, check=True)
    angles = np.random.default_rng(1).uniform(-4.0, 4.0, (50, 6))
    feet = leg_kinematics(load_robot().parameters).feet(angles, np.ones_like(angles))
    there = np.load(path)
    np.testing.assert_array_equal(there["after"], feet.position_m)
    np.testing.assert_allclose(there["few"], feet.position_m, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(there["speed"], feet.velocity_m_s, rtol=0.0, atol=1e-12)
