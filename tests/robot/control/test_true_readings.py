"""What is shown beside the model is without what the robot file says that the sensors add."""

import io
import json
import math
from pathlib import Path

import numpy as np
import pytest

from gap.interfaces import Cause
from model.values.tick import Tick
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_stamped_ticks
from robot.cli.main import run
from robot.config.robot_file import load_robot, parse_robot
from robot.control.effect_uses import true_forces_of, true_forces_of_log
from robot.report.summary import read_summary
from robot.view.numbers import numbers_of
from robot.view.screen import ScreenView
from robot.view.watch import ticks_with_true_forces
from tests.gap.test_correction import corrected
from tests.gap.walks import cause

CONFIG = load_robot()
BIAS_N = -7.0


def _drive(folder: Path, *causes: Cause) -> Path:
    """Stand for a second on a virtual robot that has the causes of its file."""
    file, log = folder / f"{len(causes)}.toml", folder / f"{len(causes)}.mcap"
    file.write_text(corrected(CONFIG.text, *causes) if causes else CONFIG.text, encoding="utf-8")
    words = ["drive", "--readonly", "--duration", "1", "--virtual-time", "--robot", str(file)]
    assert run([*words, "--log", str(log)]) == 0
    return log


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A log of a healthy robot, and of one whose file says that a sensor reads 7 N too little."""
    folder = tmp_path_factory.mktemp("logs")
    return _drive(folder), _drive(folder, cause("force_bias", 0.0, 0.0, BIAS_N, legs=("ML",)))


def test_the_log_keeps_what_the_sensor_said(logs: tuple[Path, Path]) -> None:
    healthy, biased = (read_log(path).force_n for path in logs)
    apart = np.nanmean(biased - healthy, axis=0)
    assert apart[1, 2] == pytest.approx(BIAS_N, abs=0.1)
    assert np.abs(np.delete(apart, 1, axis=0)).max() < 0.1


def test_view_shows_the_force_without_the_bias(logs: tuple[Path, Path]) -> None:
    shown = []
    for path in logs:
        contents = LogContents()
        *_, last = ticks_with_true_forces(read_stamped_ticks(path, contents), contents)
        numbers = dict(numbers_of(last.tick, contents.machine(last.tick)))
        shown.append(numbers["/force/ML"]["measured.z_n"])
    assert shown[1] == pytest.approx(shown[0], abs=0.3)


def test_the_screen_of_a_drive_shows_it_too(logs: tuple[Path, Path]) -> None:
    contents = LogContents()
    *_, last = read_stamped_ticks(logs[1], contents)
    config = parse_robot(contents.config_text)
    tick: Tick = last.tick

    def screen(corrects: bool) -> str:
        out = io.StringIO()
        own = true_forces_of(config) if corrects else None
        view = ScreenView(contents.machine(last.tick), "a title", "a help", out, own)
        view.show(tick)
        view.close()
        line = next(line for line in out.getvalue().splitlines() if line.startswith("ML"))
        return line.split()[5]

    assert float(screen(corrects=True)) - float(screen(corrects=False)) == pytest.approx(
        -BIAS_N, abs=0.11
    )


def test_show_compares_what_the_file_believes(
    logs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    (_, healthy), (_, biased) = (read_summary(path) for path in logs)
    assert np.nanmean(biased.force_n - healthy.force_n, axis=0) == pytest.approx(0.0, abs=0.1)
    assert run(["show", str(logs[1]), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_gain_drift_and_rotation_are_of_their_own_time() -> None:
    causes = (cause("force_drift", 0.5, legs=("ML",)), cause("force_gain", 1.25, legs=("ML",)))
    own = true_forces_of(parse_robot(corrected(CONFIG.text, *causes)))
    assert own is not None
    reading = np.zeros((3, 6, 3))
    since_s = np.array([0.0, 4.0, 10.0])
    reading[:, 1, 2] = 1.25 * 8.0 + 0.5 * since_s
    assert own(reading, since_s)[:, 1, 2] == pytest.approx([8.0] * 3)
    alone = [float(own(reading[i], since_s[i])[1, 2]) for i in range(3)]
    assert alone == pytest.approx([8.0] * 3)
    assert math.isnan(own(np.full((6, 3), np.nan), 0.0)[1, 2])


def test_without_such_an_effect_nothing_is_touched() -> None:
    assert true_forces_of(CONFIG) is None
    file = corrected(CONFIG.text, cause("payload", 0.5, 0.0, 0.0))
    assert true_forces_of(parse_robot(file)) is None
    assert true_forces_of_log("no robot file at all") is None
