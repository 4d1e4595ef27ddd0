"""What an explanation comes to by itself: the right one closes the gap, a decoy what it can."""

import json
from pathlib import Path

import numpy as np
import pytest

from gap.diagnosis.alone import each_alone
from gap.machines.servo_bench.simulator import servo_bench
from model.errors import GapError
from record.trial.trial import Trial, write_trial
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from tests.gap.bench_trials import IDEAL, servo_trial

DELAY_S, OFFSET_RAD = 0.08, 0.05


def late_trials() -> list[Trial]:
    rng = np.random.default_rng(3)
    t = np.arange(600) / 50
    trials = []
    for number in range(4):
        f = 0.4 + 0.15 * number
        command = np.sin(2 * np.pi * f * t)
        shaft = np.sin(2 * np.pi * f * np.fmax(t - DELAY_S, 0)) + OFFSET_RAD
        trials.append(servo_trial(IDEAL, command, shaft + rng.normal(0, 1e-3, len(t))))
    return trials


def test_the_pair_that_is_there_closes_the_gap_and_each_alone_its_part() -> None:
    trials = late_trials()
    sets = [("command_delay",), ("encoder_offset",), ("command_delay", "encoder_offset")]
    delay, offset, both = each_alone(trials, servo_bench(trials), sets)
    values = [cause.values[0] for cause in both.causes]
    assert values == pytest.approx([DELAY_S, OFFSET_RAD], rel=0.02)
    cuts = [one.channels[0].cut for one in (delay, offset, both)]
    assert cuts[2] > 0.95
    assert 0.3 < cuts[0] < 0.9
    assert cuts[1] < 0.2
    low, high = both.channels[0].after_range
    assert low <= both.channels[0].after <= high < 2e-3


def test_an_effect_that_is_not_there_is_an_error_with_the_names() -> None:
    trials = late_trials()
    with pytest.raises(GapError, match="no effect that fits these trials; there are command_delay"):
        each_alone(trials, servo_bench(trials), [("winding_resistance",)])


def test_the_command_prints_each_and_tells_a_program(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = []
    for number, trial in enumerate(late_trials()):
        paths.append(str(tmp_path / f"{number}.parquet"))
        write_trial(trial, Path(paths[-1]))
    words = [
        "gap",
        "diagnose",
        "--alone",
        *paths,
        "--effect",
        "command_delay",
        "--effect",
        "encoder_offset",
    ]
    assert cli.run([*words, "--joint", "arm"]) == ExitCode.OK
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("shaft_error arm: RMS ")
    assert lines[1].split()[0] == "command_delay", "the better one first"
    assert cli.run([*words, "--json"]) == ExitCode.OK
    told = json.loads(capsys.readouterr().out)
    assert [one["effects"] for one in told] == [["command_delay"], ["encoder_offset"]]
    assert told[0]["channels"][0]["cut"] > 0.3
    assert cli.run([*words, "--joint", "leg"]) == ExitCode.LOG
    assert "there is no joint leg; there are arm" in capsys.readouterr().err
