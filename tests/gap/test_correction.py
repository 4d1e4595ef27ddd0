"""A corrected robot file is the simulator with the effect: for every effect, through text and back."""

from dataclasses import replace

import numpy as np
import pytest

from gap.delegate import MachineOfEach, machine_key
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.remeasured import remeasure
from gap.interfaces import Cause, Drive, Scope
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.catalogue import CATALOGUE
from model.effects.correction import correction_of, merged
from model.effects.machine import parse_machine
from model.errors import ConfigError, GapError
from model.values.parameters import FourBarParameters
from robot.config.edit import check_edited, edit_robot
from robot.config.robot_file import load_robot, parse_robot
from robot.control.effect_uses import USES
from tests.gap.walks import cause, machine, simulator, walk
from tests.soaked import soaked

TEXT = load_robot().text
LEGS = machine().legs.names
NAMES = [effect.name for effect in CATALOGUE]
# Where one spread beyond neutral would do nothing, or nothing in a walk of a few seconds.
SIZES = {
    "servo_speed_limit": (1.2,),
    "ground_step": (0.005, 0.02),
    "friction_patch": (0.6, 0.02),
    "payload": (0.8, 0.1, -0.05),
    "stiction": (1.5, 0.01),
    "ground_stiffness": (0.7,),
    "marker_on_shank": (0.4,),
    "friction_anisotropy": (0.5, 0.2),
    "link_length": (0.001, -0.0005, 0.0005),
}


def sized(name: str, legs: tuple[str, ...] | None = None) -> Cause:
    effect = next(one for one in CATALOGUE if one.name == name)
    values = SIZES.get(name) or tuple(p.neutral + 1.5 * p.spread for p in effect.parameters)
    if legs is None:
        legs = () if Scope.ALL in effect.scopes else ("ML",)
    return Cause(name, legs, values)


def corrected(text: str, *causes: Cause) -> str:
    edited = edit_robot(text, correction_of(causes, LEGS), "a test")
    check_edited(edited.text, text)
    return edited.text


# The first of each stage in make test.
FIRST = {effect.stage: effect.name for effect in reversed(CATALOGUE) if effect.name in NAMES}


@pytest.mark.parametrize("name", soaked(NAMES, lambda name: name in FIRST.values()))
def test_the_corrected_file_closes_the_gap_of_every_effect(name: str) -> None:
    wrong = sized(name)
    seconds = 6.0 if name in {"ground_step", "friction_patch"} else 3.0
    trial = walk("metachronal", 0.3, seconds, (wrong,))
    file = LeggedSimulator(parse_machine(corrected(TEXT, wrong)))
    for drive in Drive:
        there = simulator().predict(trial, (wrong,), drive)
        assert np.nanmax(np.abs(there - simulator().predict(trial, (), drive))) > 1e-7
        read = file.predict(trial, (), drive)
        assert np.allclose(read, there, rtol=1e-7, atol=1e-7, equal_nan=True)


@pytest.mark.parametrize("name", [e.name for e in CATALOGUE if len(e.scopes) == 2], ids=str)
def test_an_effect_of_one_leg_or_all_goes_where_it_belongs(name: str) -> None:
    wrong = sized(name, ("FR",))
    trial = walk("tripod", 0.3, 2.0)
    file = LeggedSimulator(parse_machine(corrected(TEXT, wrong)))
    there = simulator().predict(trial, (wrong,), Drive.COMMAND)
    assert np.allclose(file.predict(trial, (), Drive.COMMAND), there, atol=1e-7, equal_nan=True)


def test_every_effect_has_a_use_in_the_controller() -> None:
    assert sorted(USES) == sorted(NAMES)


def test_comments_and_all_else_survive() -> None:
    text = corrected(TEXT, cause("foot_friction", 0.5, legs=("ML",)), cause("command_delay", 0.05))
    old, new = TEXT.splitlines(), text.splitlines()
    changed = [i for i, line in enumerate(old) if new[i] != line]
    assert [old[i].split(" =")[0] for i in changed] == ["mu"]
    line = new[changed[0]]
    assert line.startswith("mu = [0.6, 0.3, 0.6, 0.6, 0.6, 0.6]")
    assert line.endswith("# assumed")
    assert new[-2:] == ["[effects.command_delay.all]", "delay_s = 0.05"]
    assert "#   contact.mu[ML]: 0.6 -> 0.3 (foot_friction at ML)" in new
    assert parse_robot(text).effects == (cause("command_delay", 0.05),)


def test_a_second_correction_adds_to_the_first() -> None:
    first = corrected(TEXT, cause("command_delay", 0.05), cause("payload", 1.0, 0.1, 0.0))
    both = corrected(first, cause("command_delay", 0.02), cause("payload", 1.0, 0.0, 0.2))
    delay, load = parse_robot(both).effects
    assert delay.values == pytest.approx((0.07,))
    assert load.values == pytest.approx((2.0, 0.05, 0.1))
    step = corrected(TEXT, cause("ground_step", 0.004, 0.3))
    with pytest.raises(GapError, match=r"ground_step\.all has x_m = 0.3 already"):
        corrected(step, cause("ground_step", 0.004, 0.8))
    lagging = corrected(TEXT, cause("servo_lag", 0.05))
    with pytest.raises(GapError, match=r"servo_lag\.all is there already, and two of it"):
        corrected(lagging, cause("servo_lag", 0.02))
    grown = corrected(step, cause("ground_step", 0.002, 0.3))
    assert parse_robot(grown).effects[0].values == pytest.approx((0.006, 0.3))
    limit = merged((cause("servo_speed_limit", 1.0),), ())
    slower = cause("servo_speed_limit", 0.8)
    assert merged(limit, (slower,)) == (slower,)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[effects.comand_delay.all]\ndelay_s = 0.1", "did you mean 'command_delay'"),
        ("[effects.command_delay.ML]\ndelay_s = 0.1", "touches the whole robot"),
        ("[effects.force_bias.all]\nz_n = 1.0", "touches single legs"),
        ("[effects.force_bias.XX]\nz_n = 1.0", "is no place; places are all, HL"),
        ("[effects.command_delay.all]\ndelay = 0.1", "command_delay has delay_s"),
        ("[effects.command_delay.all]\ndelay_s = 9.0", "must be from 0 to 0.3"),
        ("[effects.command_delay.all]\ndelay_s = 'x'", "must be a number"),
    ],
)
def test_effects_that_make_no_sense_are_refused(table: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_robot(f"{TEXT}\n{table}\n")
    with pytest.raises(GapError, match=words):
        parse_machine(f"{TEXT}\n{table}\n")


def test_what_a_file_cannot_hold_is_refused() -> None:
    with pytest.raises(GapError, match="user's own"):
        corrected(TEXT, cause("my_own", 1.0))
    with pytest.raises(GapError, match=r"would be impossible: .*cannot turn"):
        corrected(TEXT, cause("link_length", 0.0, 0.0, -0.01), cause("link_length", 0.01, 0.0, 0.0))
    with pytest.raises(ConfigError, match=r"contact.mu: is not in the robot file"):
        edit_robot(
            "[legs]\norder = ['A', 'B', 'C']\nshaft_position = [[0,0,0],[0,1,0],[1,0,0]]\n",
            correction_of([cause("foot_friction", 0.5, legs=("A",))], ("A", "B", "C")),
            "a test",
        )


def test_measured_again_the_gap_is_closed_and_references_keep_their_file() -> None:
    wrong = cause("force_bias", 0.0, 0.0, -3.0, legs=("ML",))
    trials = [
        walk("tripod", f, 8.0, (wrong,), noise_seed=i) for i, f in enumerate((0.2, 0.25, 0.3))
    ]
    healthy = tuple(walk("tripod", 0.2, 8.0, noise_seed=9 + i) for i in range(3))
    text = corrected(TEXT, wrong)
    after = LeggedSimulator(parse_machine(text))
    shares: list[float] = []
    far = remeasure(commissioned_study(trials, simulator(), healthy), after, progress=shares.append)
    assert far.after < 1.3
    assert far.shrink > 0.97
    assert shares[-1] == pytest.approx(1.0)
    changed = replace(trials[0], header=replace(trials[0].header, robot_text="changed"))
    before = machine_key(healthy[0].header)
    both = MachineOfEach(
        [(machine_key(changed.header), "new.toml", after), (before, "old.toml", simulator())]
    )
    for one, file in ((changed, after), (healthy[0], simulator())):
        expected = file.predict(one, (), Drive.COMMAND)
        assert np.array_equal(both.predict(one, (), Drive.COMMAND), expected, equal_nan=True)
    other = replace(machine(), legs=replace(machine().legs, names=tuple("ABCDEF")))
    with pytest.raises(GapError, match=r"joints may not differ .*new.toml and old.toml"):
        MachineOfEach(
            [(machine_key(changed.header), "new.toml", LeggedSimulator(other)),
             (before, "old.toml", simulator())]
        )  # fmt: skip


def test_links_of_a_file_that_calls_its_leg_linkage_are_changed_there() -> None:
    old = TEXT.replace("[leg] ", "[linkage] ").replace('kind = "four_bar"', "#")
    text = corrected(old, cause("link_length", 0.001, 0.0, 0.0))
    assert "crank = 0.031" in text
    assert "[leg]" not in text
    leg = parse_machine(text).leg
    assert isinstance(leg, FourBarParameters)
    assert leg.crank == 0.031


FOUR_BAR_TABLE = TEXT[TEXT.index('kind = "four_bar"') : TEXT.index("[contact]")]
WHEEL_TEXT = TEXT.replace(FOUR_BAR_TABLE, 'kind = "crank"\nlength = 0.12\nradius = 0.06\n\n')


def test_what_legs_cannot_have_is_refused_in_a_sentence() -> None:
    with pytest.raises(GapError, match="cannot have link_length: a crank has no links"):
        corrected(WHEEL_TEXT, cause("link_length", 0.001, 0.0, 0.0))
    with pytest.raises(GapError, match=r"cannot have foot_rolling.*roll already"):
        corrected(WHEEL_TEXT, cause("foot_rolling", 0.01))
    with pytest.raises(ConfigError, match=r"effects\.link_length\.ML: cannot be: a crank has no"):
        parse_robot(WHEEL_TEXT + "[effects.link_length.ML]\ncrank_m = 0.001\n")
    wheel = LeggedSimulator(parse_machine(WHEEL_TEXT))
    offered = {effect.name for effect in wheel.effects}
    assert set(NAMES) - offered == {"link_length", "foot_rolling"}
    straight = LeggedSimulator(parse_machine(WHEEL_TEXT.replace("radius = 0.06", "")))
    assert "foot_rolling" in {effect.name for effect in straight.effects}
    assert [effect.name for effect in simulator().effects] == NAMES
    text = corrected(WHEEL_TEXT, cause("leg_stiffness", 0.5, legs=("ML",)))
    assert parse_machine(text).contact.stiffness[1] == 1250.0
