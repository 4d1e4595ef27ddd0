"""Every effect at its neutral value is the simulator as it stands, bit for bit, in both drives."""

from functools import cache

import numpy as np
import pytest

from gap.interfaces import Cause, Drive, Scope
from model.effects.catalogue import CATALOGUE, STAGES
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.walks import cause, simulator, walk

EFFECTS = CATALOGUE
WITH_NUMBERS = tuple(effect for effect in EFFECTS if effect.parameters)
SHARED_NAMES = """command_delay servo_lag servo_speed_limit servo_compliance
servo_compliance_beyond_encoder gear_backlash gear_backlash_in_loop gear_backlash_dragged
gear_backlash_beyond_encoder joint_friction shaft_zero_offset
link_length hip_mount_offset leg_flex leg_stiffness ground_stiffness leg_length ground_slope ground_step
com_offset payload chassis_twist foot_friction friction_level friction_anisotropy coulomb_friction
stiction stick_slip friction_patch foot_rolling tilt_coupling inertia_lag tether_force drag
force_gain force_bias
force_drift force_rotation force_cross_talk force_delay
force_lowpass pose_delay pose_yaw_offset pose_origin_offset marker_on_shank clock_skew encoder_scale"""


def test_the_catalogue_has_every_effect_that_diagnoses_share_in_order() -> None:
    assert [effect.name for effect in EFFECTS] == SHARED_NAMES.split()
    stages = [STAGES.index(effect.stage) for effect in EFFECTS]
    assert stages == sorted(stages)
    assert simulator().effects == EFFECTS


def test_numbers_make_sense() -> None:
    for effect in EFFECTS:
        assert effect.physics.endswith("."), effect.name
        assert effect.remedy.endswith("."), effect.name
        for parameter in effect.parameters:
            assert parameter.lower <= parameter.neutral <= parameter.upper, effect.name
            assert parameter.spread > 0, effect.name


@cache
def healthy(causes: tuple[Cause, ...], drive: Drive) -> tuple[Trial, FloatArray]:
    """A short walk and its prediction without the effect, once for all effects."""
    trial = walk("metachronal", 0.2, 3.0, noise_seed=2)
    return trial, simulator().predict(trial, causes, drive)


@cache
def on_a_slope(drive: Drive) -> tuple[Trial, FloatArray]:
    """A longer walk and its prediction without an effect."""
    trial = walk("metachronal", 0.2, 8.0, causes=(cause("ground_slope", 0.01, 0.0),), noise_seed=2)
    return trial, simulator().predict(trial, (), drive)


@pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)
@pytest.mark.parametrize("effect", WITH_NUMBERS, ids=lambda e: e.name)
def test_neutral_is_the_base_bit_for_bit(effect: object, drive: Drive) -> None:
    found = next(e for e in WITH_NUMBERS if e is effect)
    values = tuple(parameter.neutral for parameter in found.parameters)
    legs = ("ML",) if Scope.JOINT in found.scopes else ()
    for law in ((), (cause("coulomb_friction"),)):
        trial, base = healthy(law, drive)
        neutral = simulator().predict(trial, (*law, Cause(found.name, legs, values)), drive)
        assert np.array_equal(base, neutral, equal_nan=True)


@pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)
@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_another_value_is_not_the_base(effect: object, drive: Drive) -> None:
    found = next(e for e in EFFECTS if e is effect)
    trial, base = on_a_slope(drive)
    values = tuple(
        np.clip(p.neutral - p.spread, p.lower, p.upper)
        if p.upper == p.neutral
        else np.clip(p.neutral + p.spread, p.lower, p.upper)
        for p in found.parameters
    )
    if found.name in {"ground_step", "friction_patch"}:
        values = (values[0], 0.1)  # an edge within the walk's reach
    legs = ("ML",) if Scope.JOINT in found.scopes else ()
    changed = simulator().predict(trial, (Cause(found.name, legs, values),), drive)
    assert np.isfinite(changed).all()
    if found.name == "servo_speed_limit":
        return  # one spread below no limit is still faster than this gait; it has a test of its own
    assert np.abs(changed - base).max() > 1e-9


def test_the_same_question_has_the_same_answer() -> None:
    from gap.machines.legged.simulator import LeggedSimulator
    from tests.gap.walks import machine

    trial = walk("tripod", 0.2, 3.0, noise_seed=3)
    causes = (cause("coulomb_friction"), cause("servo_compliance", 0.02))
    first = simulator().predict(trial, causes, Drive.COMMAND)
    again = LeggedSimulator(machine()).predict(trial, causes, Drive.COMMAND)
    assert np.array_equal(first, again)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (Cause("gremlins", (), ()), "is no effect of this simulator"),
        (Cause("command_delay", (), ()), "takes delay_s"),
        (Cause("command_delay", ("ML",), (0.01,)), "touches the whole robot"),
        (Cause("force_gain", (), (1.1,)), "touches single legs"),
        (Cause("force_gain", ("XX",), (1.1,)), "is no leg"),
        (Cause("force_gain", ("ML",), (9.0,)), "must be from 0.3 to 3"),
        (Cause("force_gain", ("ML",), (float("nan"),)), "must be finite"),
    ],
)
def test_causes_that_do_not_fit_are_refused(wrong: Cause, words: str) -> None:
    with pytest.raises(GapError, match=words):
        simulator().predict(walk("tripod", 0.2, 3.0), (wrong,), Drive.COMMAND)


def test_several_legs_in_one_cause_are_several_causes() -> None:
    trial = walk("tripod", 0.2, 3.0)
    both = (cause("force_gain", 1.2, legs=("ML", "FR")),)
    each = (cause("force_gain", 1.2, legs=("ML",)), cause("force_gain", 1.2, legs=("FR",)))
    one = simulator().predict(trial, both, Drive.COMMAND)
    assert np.array_equal(one, simulator().predict(trial, each, Drive.COMMAND))
