"""Scenario files of campaigns, small: a tenth of a second of walking a trial."""

from pathlib import Path

from robot.console.arguments import DEFAULT_ROBOT_FILE

SCENARIO = """
[campaign]
seed = 1
seconds = 0.1
robots = ["bigant.toml"]
[conditions]
gaits = ["tripod"]
frequencies_hz = [0.1]
steer = [0.0]
[references]
count = 1
[cases]
controls = 1
effects = ["*"]
severities = [[0.0, 0.3], [0.7, 1.0]]
repeats = 1
pairs = 6
outside = 6
"""
FEW = SCENARIO.replace('["*"]', '["force_bias", "foot_friction"]').replace(
    "pairs = 6", "pairs = 0"
).replace("outside = 6", "outside = 0").replace(", [0.7, 1.0]]", "]")  # fmt: skip
ONE = FEW.replace(', "foot_friction"', "")


def write_scenario(folder: Path, text: str) -> Path:
    """Write a scenario and the robot file that it names; return its path."""
    (folder / "bigant.toml").write_text(DEFAULT_ROBOT_FILE.read_text())
    path = folder / "scenario.toml"
    path.write_text(text)
    return path
