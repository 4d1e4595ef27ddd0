"""The scripts in examples/ run as they stand and print what they promise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SAID = {
    "drive.py": "forward speed",
    "odometry.py": "estimator            off by",
    "own_arm.py": "The simulator lacks joint_friction_at_every_joint (elbow: coulomb_nm",
    "own_effect.py": "  force_z ML ",
    "own_machine.py": "The simulator lacks tendon_stretch at finger (rad_per_nm 0.060 +- 0.002)",
    "own_robot.py": "Octopod: 8 legs",
    "replay_test.py": "NOT EQUAL",
}
WRITES = {"own_arm.py": ("arm.html", "arm_corrected.xml")}
# Effects for --effects, a gait for --gait, walks and data for tests/robot/odometry, and pictures of named
# systems, which tests/robot/study/test_model_run.py draws.
ELSEWHERE = {"worn_crank.py", "own_gait.py", "chain_walk.py", "lab_data.py"} | {
    path.name for path in EXAMPLES.glob("model_*.py")
}


def test_every_example_is_run_by_some_test() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(SAID) | ELSEWHERE


@pytest.mark.soak
@pytest.mark.parametrize("name", SAID)
def test_an_example_runs(name: str, tmp_path: Path) -> None:
    root = str(EXAMPLES.parent)
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name)], cwd=tmp_path, capture_output=True, text=True,
        check=False, env={**os.environ, "PYTHONPATH": root},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert SAID[name] in done.stdout
    assert all((tmp_path / file).is_file() for file in WRITES.get(name, ()))


def test_the_lab_s_own_effect_is_the_one_of_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    from robot.cli import main as cli

    words = ["gap", "effects", "--effects", str(EXAMPLES / "worn_crank.py")]
    assert cli.run([*words, "--stage", "kinematics"]) == 0
    assert "worn_crank" in capsys.readouterr().out
    page = (EXAMPLES.parent / "docs" / "gap_effects.md").read_text(encoding="utf-8")
    body = (EXAMPLES / "worn_crank.py").read_text(encoding="utf-8")
    assert body[body.index("EFFECTS = [") :] in page
