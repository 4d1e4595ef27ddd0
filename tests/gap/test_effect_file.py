"""Users' effects: the example of the documentation works, and files that do not fit are refused."""

import re
from pathlib import Path

import numpy as np
import pytest

from gap.effect_file import UserEffect, read_effects
from gap.interfaces import Drive
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.catalogue import STAGES
from model.errors import GapError
from tests.gap.walks import cause, command_trial, machine, simulator, walk

DOCS = Path(__file__).resolve().parents[2] / "docs" / "gap_effects.md"


@pytest.fixture
def example(tmp_path: Path) -> Path:
    found = re.search(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    path = tmp_path / "worn_crank.py"
    path.write_text(found.group(1), encoding="utf-8")
    return path


def test_the_example_of_the_documentation_moves_its_foot(example: Path) -> None:
    added = read_effects(example, STAGES, ())
    ours = LeggedSimulator(machine(), added)
    assert [e.name for e in ours.effects][-1] == "worn_crank"
    trial = walk("tripod", 0.2, 4.0)
    for drive in Drive:
        base = simulator().predict(trial, (), drive)
        neutral = ours.predict(trial, (cause("worn_crank", 0.0, legs=("ML",)),), drive)
        assert np.array_equal(base, neutral)
        got = ours.predict(trial, (cause("worn_crank", 0.002, legs=("ML",)),), drive)
        at = next(k for k, c in enumerate(ours.channels) if (c.name, c.joint) == ("foot_z", "ML"))
        shaft = np.interp(
            np.arange(len(got)) * 0.04,
            trial.time_s,
            command_trial("tripod", 0.2, 4.0).command_rad[:, 1],
        )
        unloaded = got[:, at] - base[:, at]
        load = base[:, next(k for k, c in enumerate(ours.channels) if c.name == "force_z") + 1]
        air = load == 0
        if drive is Drive.MEASURED:
            assert np.allclose(unloaded[air], 0.002 * np.sin(shaft[air]), atol=1e-4)
        else:
            assert np.abs(unloaded).max() > 1e-3


BAD = (
    ("EFFECTS = []", "has no list EFFECTS"),
    ("x = 1", "has no list EFFECTS"),
    ("EFFECTS = [1]", "must hold UserEffect"),
    ("1 / 0", "cannot be run: ZeroDivisionError"),
    ("def broken(:", "cannot be run: SyntaxError"),
)


@pytest.mark.parametrize(("text", "words"), BAD)
def test_files_that_hold_no_effects_are_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "effects.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(GapError, match=words):
        read_effects(path, STAGES, ())


def test_effects_that_do_not_fit_are_refused(example: Path) -> None:
    with pytest.raises(GapError, match="already"):
        read_effects(example, STAGES, ("worn_crank",))
    with pytest.raises(GapError, match="names the stage 'kinematics'; stages are motor"):
        read_effects(example, ("motor",), ())
    with pytest.raises(GapError, match="there is no file"):
        read_effects(example.with_name("none.py"), STAGES, ())
    text = example.read_text(encoding="utf-8")
    for old, new, words in (
        ("0.0, 0.0, 0.01, 0.001", "0.5, 0.0, 0.01, 0.001", "needs lower <= neutral <= upper"),
        ("0.0, 0.0, 0.01, 0.001", "0.0, 0.0, 0.01, 0.0", "a spread above 0"),
        ("(Scope.JOINT,)", "()", "needs a scope"),
    ):
        assert old in text
        example.write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(GapError, match=words):
            read_effects(example, STAGES, ())


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_takes_effects_of_a_user(stage: str) -> None:
    from dataclasses import fields, replace
    from typing import Any

    from gap.interfaces import Effect, Scope

    def nudge(signals: Any, _values: tuple[float, ...], _legs: tuple[bool, ...]) -> Any:
        last = {
            "actuation": "shaft_rad", "kinematics": "position_m", "support": "ground_m",
            "friction": "mu", "external": "wrench_B", "dynamics": "velocity_B", "sensing": "body_m",
        }[stage]  # fmt: skip
        assert last in {field.name for field in fields(signals)}
        value = getattr(signals, last) + 0.0
        value[..., -1] += 0.01
        return replace(signals, **{last: value})

    effect = Effect("nudge", stage, (), (Scope.ALL,), "A nudge.", "None.")
    ours = LeggedSimulator(machine(), (UserEffect(effect, nudge),))
    trial = walk("metachronal", 0.2, 3.0)
    changed = ours.predict(trial, (cause("nudge"),), Drive.COMMAND)
    base = ours.predict(trial, (), Drive.COMMAND)
    assert np.isfinite(changed).all()
    assert np.abs(changed - base).max() > 1e-4
