"""Effects of actuation and kinematics against what the physics says by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import binary_erosion

from gap.interfaces import Drive
from model.effects.shafts import _held_back
from model.kinematics.four_bar import FourBarKinematics
from model.kinematics.legs import leg_kinematics
from model.motion.filters import lagged
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import FourBarParameters
from record.trial.trial import Trial
from tests.gap.predictions import COULOMB, LEGS, ML, Prediction, inside
from tests.gap.walks import cause, command_trial, machine, simulator, walk


def commands(gait: str, frequency_hz: float, seconds: float, at_s: FloatArray) -> FloatArray:
    trial = command_trial(gait, frequency_hz, seconds)
    return np.stack([np.interp(at_s, trial.time_s, c) for c in trial.command_rad.T], axis=1)


def slopes(shaft_rad: FloatArray) -> FloatArray:
    """Foot x and z by shaft angle, from differences of the linkage, (..., N, 2)."""
    kinematics = leg_kinematics(machine())
    still = np.zeros_like(shaft_rad)
    step = 1e-6
    ahead, behind = (kinematics.feet(shaft_rad + s, still).position_m for s in (step, -step))
    return (ahead - behind)[..., [0, 2]] / (2 * step)


def test_command_delay_shifts_by_exactly_that() -> None:
    trial = walk("tripod", 0.2, 8.0)
    for drive in Drive:
        got = Prediction(trial, [cause("command_delay", 0.04)], drive)
        now = commands("tripod", 0.2, 8.0, got.time_s)
        then = commands("tripod", 0.2, 8.0, got.time_s - 0.04)
        # the corners of the clock are averaged over a frame
        assert np.abs(inside(got["shaft_error"] - (then - now))).max() < 2e-3
        assert np.median(np.abs(inside(got["shaft_error"] - (then - now)))) < 1e-6
    late, base = (Prediction(trial, c) for c in ([cause("command_delay", 0.04)], []))
    shifted = np.interp(base.time_s - 0.04, base.time_s, base["foot_x"][:, ML])
    assert np.abs(inside(late["foot_x"][:, ML] - shifted)).max() < 5e-4


def test_servo_lag_is_speed_times_time_constant() -> None:
    trial = walk("tripod", 0.1, 10.0)
    got = Prediction(trial, [cause("servo_lag", 0.1, legs=("ML",))])["shaft_error"]
    rate = np.gradient(
        commands("tripod", 0.1, 10.0, 0.04 * np.arange(len(got), dtype=np.float64)), 0.04, axis=0
    )
    steady = np.abs(np.gradient(np.gradient(rate[:, ML]))) < 1e-3
    steady &= np.abs(rate[:, ML] - np.roll(rate[:, ML], 25)) < 1e-3  # ten time constants
    assert steady.sum() > 50
    assert np.allclose(got[steady, ML], -0.1 * rate[steady, ML], atol=1e-3)
    assert np.abs(np.delete(got, ML, axis=1)).max() == 0.0


def test_a_speed_limit_falls_behind_and_catches_up() -> None:
    trial = walk("tripod", 0.2, 10.0)
    got = Prediction(trial, [cause("servo_speed_limit", 1.5)])
    shaft = got["shaft_error"] + commands("tripod", 0.2, 10.0, got.time_s)
    assert np.diff(shaft, axis=0).max() / 0.04 < 1.5 + 0.06  # the commands' corners
    assert got["shaft_error"].min() < -0.3
    assert np.abs(got["shaft_error"]).min(axis=0).max() < 1e-3
    unhurt = Prediction(trial, [cause("servo_speed_limit", 5.0)])["shaft_error"]
    assert np.abs(unhurt).max() < 1e-9


def test_a_shaft_that_is_too_slow_begins_where_it_was_measured() -> None:
    """A recording that begins in the middle of a walk finds it behind; it catches up from there."""
    trial = walk("tripod", 0.2, 12.0, [cause("servo_speed_limit", 1.5)])
    rest = trial.rows(trial.time_s >= 2.8)
    for drive in Drive:
        got = Prediction(rest, [cause("servo_speed_limit", 1.5)], drive)["shaft_error"]
        measured = simulator().observe(rest).values[:, : len(LEGS)]
        assert measured[0].min() < -0.3
        assert np.abs(got - measured).max() < 0.05
    base = Prediction(rest, [], Drive.COMMAND)["shaft_error"]
    assert np.abs(base).max() < 1e-9, "only what is limited is behind"


def test_compliance_gives_by_the_torque_of_the_load() -> None:
    trial = walk("metachronal", 0.2, 6.0)
    for drive in Drive:
        got = Prediction(trial, [COULOMB, cause("servo_compliance", 0.02)], drive)
        source = got if drive is Drive.COMMAND else Prediction(trial)
        lever = slopes(got["shaft_error"] + commands("metachronal", 0.2, 6.0, got.time_s))
        torque = np.sum(lever * source.force[..., [0, 2]], axis=2)
        error = inside(got["shaft_error"] - 0.02 * torque)
        assert np.sqrt(np.mean(error**2)) < 0.05 * np.sqrt(np.mean((0.02 * torque) ** 2))


def test_a_give_beyond_the_encoder_moves_the_foot_and_not_the_reading() -> None:
    trial = walk("metachronal", 0.2, 6.0, [COULOMB])
    for drive in Drive:
        unseen = cause("servo_compliance_beyond_encoder", 0.004)
        got = Prediction(trial, [COULOMB, unseen], drive)
        base = Prediction(trial, [COULOMB], drive)
        assert np.array_equal(got["shaft_error"], base["shaft_error"])
        source = got if drive is Drive.COMMAND else base
        lever = slopes(got["shaft_error"] + commands("metachronal", 0.2, 6.0, got.time_s))
        turned = 0.004 * np.sum(lever * source.force[..., [0, 2]], axis=2)
        moved, expected = got["foot_x"] - base["foot_x"], lever[..., 0] * turned
        error = inside(moved - expected)
        assert np.sqrt(np.mean(error**2)) < 0.08 * np.sqrt(np.mean(expected**2))


def test_backlash_lies_on_one_flank_or_the_other() -> None:
    trial = walk("metachronal", 0.2, 10.0)
    for drive in Drive:
        width = 0.03
        got = Prediction(trial, [cause("gear_backlash", width, legs=("ML",))], drive)
        base = Prediction(trial)
        play = got["shaft_error"][:, ML] - base["shaft_error"][:, ML]
        lever = slopes(commands("metachronal", 0.2, 10.0, got.time_s))
        torque = np.sum(lever * base.force[..., [0, 2]], axis=2)[:, ML]
        assert np.abs(play).max() <= width / 2 + 1e-12
        # when it changes flanks is known to a tenth of a second or two, and blurred over that
        driven, held = steadily(torque > 0.2), steadily(torque < -0.2)
        assert np.allclose(play[driven], width / 2, atol=1e-3)
        assert np.allclose(play[held], -width / 2, atol=1e-3)
        assert driven.any()
        assert held.any()
        free = base["force_z"][:, ML] == 0
        rising, falling = lever[:, ML, 1] > 0.01, lever[:, ML, 1] < -0.01
        # a foot's weight holds it back, then draws it on; grease lets it fall in a few frames
        assert np.isclose(np.median(play[free & rising]), -width / 2)
        assert np.isclose(np.median(play[free & falling]), width / 2)
        assert (np.abs(play[free]) < width / 4).any()


def test_bearings_that_drag_keep_a_free_shaft_at_its_rear_flank() -> None:
    """Under load it lies as any shaft with play does."""
    trial = walk("metachronal", 0.2, 10.0)
    width = 0.03
    for drive in Drive:
        base, plain, dragged = (
            Prediction(trial, causes, drive)
            for causes in (
                [],
                [cause("gear_backlash", width, legs=("ML",))],
                [cause("gear_backlash_dragged", width, legs=("ML",))],
            )
        )
        free = steadily(base["force_z"][:, ML] == 0)
        place, usual = (
            (one["shaft_error"] - base["shaft_error"])[:, ML] for one in (dragged, plain)
        )
        assert np.allclose(place[free], -width / 2, atol=1e-3)
        assert usual[free].max() > 0.9 * width / 2, "a shaft that nothing drags falls"
        lever = slopes(commands("metachronal", 0.2, 10.0, base.time_s))
        torque = np.sum(lever * base.force[..., [0, 2]], axis=2)[:, ML]
        loaded = steadily(np.abs(torque) > 0.2)
        assert loaded.any()
        assert np.allclose(place[loaded], usual[loaded], atol=1e-3)


@pytest.mark.parametrize("form", ["gear_backlash", "gear_backlash_beyond_encoder"])
def test_the_zero_of_a_load_cell_holds_no_free_shaft_against_a_flank(form: str) -> None:
    """A foot weighs half a newton; a load cell may be off by as much, and pushes at nothing."""
    trial = walk("metachronal", 0.2, 6.0)
    off = replace(trial, force_n=trial.force_n + np.array([0.0, 0.0, 0.8]))
    name = "shaft_error" if form == "gear_backlash" else "foot_x"
    moved = []
    for one in (trial, off):
        got, base = (
            Prediction(one, causes, Drive.MEASURED)
            for causes in ([cause(form, 0.03, legs=("ML",))], [])
        )
        moved.append((got[name] - base[name])[:, ML])
    air = np.asarray(binary_erosion(trial_in_air(got, trial), iterations=8))
    assert air.any()
    assert np.ptp(moved[0][air]) > 0.5 * np.ptp(moved[0])
    assert np.allclose(moved[1][air], moved[0][air], atol=0.02 * np.ptp(moved[0]))


def trial_in_air(seen: Prediction, trial: Trial) -> BoolArray:
    """Where the foot of ML bears nothing, at the frames of a prediction."""
    bears = np.interp(seen.time_s, trial.time_s, trial.force_n[:, ML, 2])
    return np.asarray(bears < 1e-3)


def test_play_within_the_loop_is_taken_back_in_the_time_of_its_lag() -> None:
    trial = walk("metachronal", 0.2, 10.0)
    for drive in Drive:
        lag = cause("servo_lag", 0.08)
        for causes, constant_s in (([], 0.05), ([lag], 0.08)):
            base = Prediction(trial, causes, drive)
            plain, loop = (
                Prediction(trial, [*causes, cause(form, 0.03, legs=("ML",))], drive)["shaft_error"]
                - base["shaft_error"]
                for form in ("gear_backlash", "gear_backlash_in_loop")
            )
            rest = plain[:, ML] - lagged(plain[:, ML], constant_s, base.time_s[1] - base.time_s[0])
            assert np.allclose(inside(loop[:, ML] - rest), 0.0, atol=2e-3)
            assert np.abs(inside(loop[:, ML])).max() < 0.03
            assert np.abs(inside(loop[:, ML])).max() > 0.003
            assert not np.delete(loop, ML, axis=1).any() or drive is Drive.COMMAND


def test_play_beyond_the_encoder_moves_the_foot_and_not_the_reading() -> None:
    trial = walk("metachronal", 0.2, 6.0)
    unseen, seen = (
        Prediction(trial, [cause(form, 0.03, legs=("ML",))], Drive.MEASURED)
        for form in ("gear_backlash_beyond_encoder", "gear_backlash")
    )
    base = Prediction(trial, [], Drive.MEASURED)
    assert np.array_equal(unseen["shaft_error"], base["shaft_error"])
    place = (seen["shaft_error"] - base["shaft_error"])[:, ML]
    moved = (unseen["foot_x"] - base["foot_x"])[:, ML]
    lever = slopes(commands("metachronal", 0.2, 6.0, base.time_s))[:, ML, 0]
    expected = lever * place
    assert np.sqrt(np.mean(inside(moved - expected) ** 2)) < 0.15 * np.sqrt(np.mean(expected**2))


def steadily(so: BoolArray) -> BoolArray:
    """Where something is so, and was and will be for a fifth of a second."""
    return binary_erosion(so, iterations=5)


def test_a_tight_joint_stays_as_far_behind_as_friction_holds_it() -> None:
    trial = walk("tripod", 0.1, 10.0)
    for drive in Drive:
        got = Prediction(trial, [cause("joint_friction", 0.02, legs=("ML",))], drive)
        behind = got["shaft_error"][:, ML]
        # a crank that always turns one way is behind all the time
        assert np.allclose(behind, -0.02, atol=1e-9)
        assert np.abs(np.delete(got["shaft_error"], ML, axis=1)).max() == 0.0


def test_a_tight_joint_under_a_position_loop_that_turns_round() -> None:
    # an oracle in small steps: a shaft with next to no inertia, a spring of 50 N m/rad, friction of 1 N m
    time_s = 1e-3 * np.arange(8000)
    wanted = 0.3 * np.sin(2 * np.pi * 0.5 * time_s) + 0.05 * np.sin(2 * np.pi * 1.3 * time_s)
    at, stood = wanted[0] - 0.02, []
    for goal in wanted:
        pull = 50.0 * (goal - at)
        at += (np.sign(pull) * max(abs(pull) - 1.0, 0.0)) / 50.0
        stood.append(at)
    shafts = _held_back(np.column_stack([wanted, wanted]), np.array([0.02, 0.0]))
    assert np.abs(shafts[:, 0] - stood).max() < 1e-12
    assert np.array_equal(shafts[:, 1], wanted)
    unknown = wanted.copy()
    unknown[100:200] = np.nan
    held = _held_back(unknown[:, None], np.array([0.02]))[:, 0]
    assert np.array_equal(np.isnan(held), np.isnan(unknown))
    assert np.abs(held - stood)[1000:].max() < 1e-12


def test_the_encoder_does_not_see_a_zero_offset() -> None:
    trial = walk("tripod", 0.2, 5.0)
    for drive in Drive:
        got = Prediction(trial, [cause("shaft_zero_offset", 0.05, legs=("ML",))], drive)
        base = Prediction(trial, [], drive)
        assert np.array_equal(got["shaft_error"], base["shaft_error"])
        shafts = commands("tripod", 0.2, 5.0, got.time_s)
        moved = got["foot_x"] - base["foot_x"]
        expected = 0.05 * slopes(shafts + 0.025)[:, ML, 0]
        assert np.allclose(inside(moved[:, ML]), inside(expected), atol=2e-4)
        assert np.abs(np.delete(moved, ML, axis=1)).max() == 0.0


def test_longer_links_are_another_linkage() -> None:
    trial = walk("tripod", 0.2, 5.0)
    for drive in Drive:
        for legs in ((), ("ML",)):
            got = Prediction(
                trial, [cause("link_length", 0.001, -0.0005, 0.0008, legs=legs)], drive
            )
            nominal = machine().leg
            assert isinstance(nominal, FourBarParameters)
            links = replace(nominal, crank=0.031, coupler=0.1315, rocker=0.0448)
            other = FourBarKinematics(links, machine().legs.shaft_position)
            shafts = commands("tripod", 0.2, 5.0, got.time_s)
            feet = other.feet(shafts, np.zeros_like(shafts)).position_m
            assert np.allclose(inside(got["foot_x"][:, ML]), inside(feet[:, ML, 0]), atol=3e-4)
            if legs:
                base = Prediction(trial, [], drive)
                assert np.array_equal(got["foot_x"][:, ML + 1], base["foot_x"][:, ML + 1])


def test_a_moved_hip_moves_its_foot_by_as_much() -> None:
    trial = walk("tripod", 0.2, 5.0)
    for drive in Drive:
        got = Prediction(trial, [cause("hip_mount_offset", 0.01, -0.006, legs=("ML",))], drive)
        moved = got.feet - Prediction(trial, [], drive).feet
        assert np.allclose(moved[:, ML, 0], 0.01, atol=1e-12)
        assert np.allclose(moved[:, ML, 1], -0.006, atol=1e-12)
        assert np.abs(np.delete(moved[..., :2], ML, axis=1)).max() == 0.0


def test_flexible_feet_give_by_force_times_compliance() -> None:
    trial = walk("metachronal", 0.2, 6.0, [COULOMB])
    lateral, along = 1e-4, 4e-5
    for drive in Drive:
        got = Prediction(trial, [COULOMB, cause("leg_flex", lateral, along)], drive)
        source = got if drive is Drive.COMMAND else Prediction(trial, [COULOMB])
        moved = got.feet - Prediction(trial, [COULOMB], drive).feet
        given = source.force[..., :2] * [along, lateral]
        error = inside(moved[..., :2] - given)
        # measured forces were averaged to frames of their own where they jump
        assert np.sqrt(np.mean(error**2)) < 0.03 * np.sqrt(np.mean(given**2))
        assert np.median(np.abs(error)) < 1e-7
    # forces build up instead of jumping
    stiff, soft = (
        Prediction(trial, c)["force_y"]
        for c in ([COULOMB], [COULOMB, cause("leg_flex", 3e-4, 0.0)])
    )
    assert np.abs(np.diff(soft, axis=0)).sum() < 0.9 * np.abs(np.diff(stiff, axis=0)).sum()
