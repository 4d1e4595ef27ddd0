"""Rigid bodies under diagnosis against MuJoCo stepped apart: native effects, trees, batches, mistakes."""

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machines.mujoco.machine import MjcfMachine, make_machine
from gap.machines.mujoco.quiet import quiet
from gap.search.candidates import is_limit
from model.errors import GapError
from record.trial.trial import Trial
from tests.gap.mjcf_arms import ARM, LOOP, arm, arm_log, chirps, log_of, stepped

# What steps of 2.5 ms in place of 1 ms make of a joint at 2 rad/s.
STEP_RAD = 2.5e-3
TWO_TREES = """<mujoco><worldbody>
  <body name="a"><joint name="a" axis="0 1 0"/>
    <inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/></body>
  <body name="b" pos="1 0 0"><joint name="b" axis="0 1 0"/>
    <inertial pos="0 0 -0.2" mass="2" diaginertia="0.01 0.01 0.001"/></body>
</worldbody></mujoco>"""
WEIGHT = """<body pos="{} 0 {}">
  <inertial pos="0 0 0" mass="0.4" diaginertia="1e-9 1e-9 1e-9"/></body></body></body>"""


@pytest.fixture(scope="module")
def healthy() -> Trial:
    return arm_log(4.0)


@pytest.fixture(scope="module")
def machine(healthy: Trial) -> MjcfMachine:
    return make_machine([healthy])


def off_rad(machine: MjcfMachine, trial: Trial, *causes: Cause) -> float:
    """Largest RMS difference of a joint between a trial and what is predicted of it."""
    observed = machine.observe(trial)
    error = observed.values - machine.predict(trial, causes, Drive.COMMAND)
    return float(np.sqrt(np.mean(error**2, axis=0)).max())


def test_nominal_rollouts_are_those_of_the_model_stepped_by_hand(
    machine: MjcfMachine, healthy: Trial
) -> None:
    assert off_rad(machine, healthy) < STEP_RAD


@pytest.mark.parametrize(
    ("in_file", "cause"),
    [
        ('frictionloss="0.4"', Cause("coulomb_friction", ("fore",), (0.4,))),
        ('damping="0.3"', Cause("viscous_friction", ("fore",), (0.3,))),
        ('armature="0.06"', Cause("armature", ("fore",), (0.06,))),
        (
            'frictionloss="0.4" damping="0.1" armature="0.02"',
            Cause("joint_friction", ("fore",), (0.4, 0.1, 0.02)),
        ),
    ],
)
def test_an_effect_is_what_the_file_would_say(
    machine: MjcfMachine, in_file: str, cause: Cause
) -> None:
    trial = arm_log(4.0, fore=in_file)
    assert off_rad(machine, trial) > 0.01
    assert off_rad(machine, trial, cause) < STEP_RAD


def test_a_heavier_body_and_a_payload_are_what_the_file_would_say(
    machine: MjcfMachine, healthy: Trial
) -> None:
    heavier = ARM.format(upper="", fore="").replace(
        'mass="0.5" diaginertia="0.002 0.002 0.0002"',
        'mass="0.75" diaginertia="0.003 0.003 0.0003"',
    )
    t, command = chirps(4.0)
    columns = {"time_s": t, "command_rad": command}
    trial = log_of(arm(), LOOP, columns | {"shaft_rad": stepped(heavier, command)})
    assert off_rad(machine, trial, Cause("body_mass", ("fore",), (1.5,))) < STEP_RAD
    for x_m, z_m in ((0.0, 0.0), (0.04, -0.06)):  # from the end, 0.2 m down
        loaded = arm().replace("</body></body>", WEIGHT.format(x_m, z_m - 0.2))
        trial = log_of(arm(), LOOP, columns | {"shaft_rad": stepped(loaded, command)})
        assert off_rad(machine, trial) > 0.01
        payload = Cause("payload", ("fore",), (0.4, x_m, 0.0, z_m))
        assert off_rad(machine, trial, payload) < STEP_RAD


def test_a_payload_beside_the_end_of_the_arm_is_found_where_it_hangs() -> None:
    t, command = chirps(8.0)
    loaded = arm().replace("</body></body>", WEIGHT.format(0.06, -0.26))
    trial = log_of(arm(), LOOP, {
        "time_s": t, "command_rad": command, "shaft_rad": stepped(loaded, command),
    })  # fmt: skip
    answer = diagnose([trial], make_machine([trial]))
    assert (answer.causes[0].effect, answer.causes[0].joints) == ("payload", ("fore",))
    mass_kg, x_m, _, z_m = (one.value for one in answer.causes[0].values)
    assert mass_kg == pytest.approx(0.4, rel=0.1)
    assert (x_m, z_m) == pytest.approx((0.06, -0.06), abs=0.015)


def test_every_effect_is_nothing_at_its_neutral_value(machine: MjcfMachine, healthy: Trial) -> None:
    base = machine.predict(healthy, (), Drive.COMMAND)
    for effect in machine.effects:
        place = (
            () if effect.each or len(effect.scopes) == 2 else (effect.parts or machine.joints)[:1]
        )
        place = place if effect.scopes[0].name != "ALL" else ()
        cause = Cause(effect.name, place, tuple(p.neutral for p in effect.parameters))
        again = machine.predict(healthy, (cause,), Drive.COMMAND)
        assert np.allclose(again, base, atol=1e-12), effect.name


def test_every_effect_does_something_and_is_refused_outside_its_bounds(
    machine: MjcfMachine, healthy: Trial
) -> None:
    base = machine.predict(healthy, (), Drive.MEASURED)
    for effect in machine.effects:
        if effect.each:
            continue
        place = () if effect.scopes[0].name == "ALL" else (effect.parts or machine.joints)[-1:]
        values = tuple(
            2.0 * p.lower  # what is not reached does nothing
            if is_limit(p)
            else p.neutral + 0.5 * p.spread * (1 if p.upper > p.neutral else -1)
            for p in effect.parameters
        )
        there = machine.predict(healthy, (Cause(effect.name, place, values),), Drive.MEASURED)
        assert float(np.nanmax(np.abs(there - base))) > 1e-6, effect.name
        beyond = Cause(effect.name, place, tuple(p.upper + 1e9 for p in effect.parameters))
        with pytest.raises(GapError, match=effect.name):
            machine.predict(healthy, (beyond,), Drive.COMMAND)


def test_many_at_once_is_one_by_one(machine: MjcfMachine, healthy: Trial) -> None:
    causes: list[tuple[Cause, ...]] = [
        (Cause("coulomb_friction", (joint,), (value,)),)
        for joint in machine.joints
        for value in (0.1, 0.2)
    ]
    causes += [(Cause("load_friction", ("upper",), (0.2,)),), ()]
    asked = [(healthy, own, drive) for own in causes for drive in Drive]
    together = make_machine([healthy]).predict_many(asked)
    for (trial, own, drive), many in zip(asked, together, strict=True):
        assert np.allclose(machine.predict(trial, own, drive), many, atol=1e-9, equal_nan=True)


def test_mujoco_s_profiler_rests_during_rollouts_and_a_clock_of_the_user_s_is_kept() -> None:
    model = mujoco.MjModel.from_xml_string(TWO_TREES)

    def timed() -> float:
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        return float(data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration)

    with quiet():
        assert timed() == 0.0
    assert timed() > 0.0
    ticks = iter(range(10**6))
    mujoco.set_mjcb_time(lambda: float(next(ticks)))
    try:
        with quiet():
            assert timed() >= 1.0
        assert timed() >= 1.0
    finally:
        mujoco.set_mjcb_time(None)


def test_an_unstable_candidate_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    light = re.sub(
        r'(mass|diaginertia)="[^"]*"',
        lambda m: f'{m[1]}="1e-12"' if m[1] == "mass" else 'diaginertia="1e-15 1e-15 1e-15"',
        arm(),
    )
    healthy = arm_log(1.0)
    trial = replace(healthy, header=replace(healthy.header, robot_text=light))
    with pytest.raises(GapError, match="the model explodes"):
        make_machine([trial]).predict(trial, (), Drive.COMMAND)
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_trees_share_runs_and_do_not_mix() -> None:
    t, command = chirps(2.0)
    shaft = stepped(TWO_TREES, command)
    trial = log_of(
        TWO_TREES, LOOP, {"time_s": t, "command_rad": command, "shaft_rad": shaft}, ("a", "b")
    )
    machine = make_machine([trial])
    assert machine.parts.rigid.trees == 2
    own = [
        (Cause("coulomb_friction", ("a",), (0.5,)),),
        (Cause("coulomb_friction", ("b",), (0.7,)),),
    ]
    first, second = machine.predict_many([(trial, one, Drive.COMMAND) for one in own])
    base = machine.predict(trial, (), Drive.COMMAND)
    assert np.array_equal(first[:, 1], base[:, 1])
    assert np.array_equal(second[:, 0], base[:, 0])
    whole = TWO_TREES.replace('name="a" axis', 'name="a" frictionloss="0.5" axis')
    truth = stepped(whole, command)[:, 0] - command[:, 0]
    assert float(np.abs(first[:, 0] - truth).max()) < 5e-3


def test_segments_begin_at_what_was_measured_and_stay_local(machine: MjcfMachine) -> None:
    """A wrong spell in a log spoils the segment in which it lies, and no other."""
    trial = arm_log(4.0)
    shaft = trial.shaft_rad.copy()
    shaft[195:206] += 0.2
    spoilt = replace(trial, shaft_rad=shaft)
    clean = machine.predict(trial, (), Drive.MEASURED)
    there = machine.predict(spoilt, (), Drive.MEASURED)
    differs = np.flatnonzero(np.abs(there - clean).max(axis=1) > 0.01)
    assert len(differs) > 5
    assert differs.min() >= 190
    assert differs.max() <= 300


def test_a_candidate_that_breaks_the_simulator_pays_and_a_broken_file_is_a_sentence(
    machine: MjcfMachine, healthy: Trial
) -> None:
    explosive = replace(healthy, header=replace(healthy.header, drive=LOOP.replace("40.0", "4e9")))
    with pytest.raises(GapError, match=r"explodes .* with no effect added"):
        make_machine([explosive]).predict(healthy, (), Drive.COMMAND)
    weak = LOOP.replace("40.0", "4e5")
    stiff = make_machine([replace(healthy, header=replace(healthy.header, drive=weak))])
    cause = Cause("controller_gain", (), (5.0,))
    assert np.isfinite(stiff.predict(healthy, (cause,), Drive.COMMAND)).all()


@pytest.mark.parametrize("drive", Drive, ids=lambda one: one.value)
def test_a_weaker_motor_is_all_gains_of_its_loop(
    machine: MjcfMachine, healthy: Trial, drive: Drive
) -> None:
    weaker = Cause("motor_strength", ("fore",), (0.7,))
    gains = (Cause(f"{name}_gain", ("fore",), (0.7,)) for name in ("controller", "damping"))
    got = machine.predict(healthy, (weaker,), drive)
    assert np.allclose(got, machine.predict(healthy, tuple(gains), drive), atol=1e-12)
    assert not np.allclose(got, machine.predict(healthy, (), drive), atol=1e-4)


def test_a_speed_limit_above_the_speed_of_held_commands_does_nothing(
    machine: MjcfMachine, healthy: Trial
) -> None:
    """A command that holds for 10 ms jumps, and a limit on jumps would look like a delay."""
    above = Cause("speed_limit", (), (8.0,))
    for drive in Drive:
        there, without = (machine.predict(healthy, one, drive) for one in ((above,), ()))
        assert np.allclose(there, without, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'name="fore_joint"',
            'name="elbow"',
            "no joint 'fore'; it has upper_joint, elbow: give the file",
        ),
        ("</worldbody>", "", "no model that MuJoCo can compile: .*fix it"),
        ('mass="0.5"', 'mass="-1"', "no model that MuJoCo can compile"),
    ],
)
def test_a_wrong_file_is_a_sentence(healthy: Trial, old: str, new: str, words: str) -> None:
    header = replace(healthy.header, robot_text=arm().replace(old, new))
    with pytest.raises(GapError, match=words):
        make_machine([replace(healthy, header=header)])


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ("", 'kind: is missing: write .drive. kind = "position"'),
        ('kind = "position"', "kp_nm_rad: is missing for upper"),
        ('kind = "firmware"\np_gain = 400', "supply_v: is missing for upper"),
        (LOOP + "kp_nm_radd = 3", "kp_nm_radd"),
        (
            LOOP + "[joint.elbow]\nkp_nm_rad = 3",
            "joint.elbow: is no joint of the log; there are upper, fore",
        ),
        ("kp_nm_rad = [1.0, 2.0, 3.0]", "needs a number, or 2 of them"),
    ],
)
def test_a_wrong_drive_is_a_sentence(healthy: Trial, drive: str, words: str) -> None:
    with pytest.raises(GapError, match=words):
        make_machine([replace(healthy, header=replace(healthy.header, drive=drive))])


def test_units_that_no_log_of_the_model_has_are_a_sentence(
    machine: MjcfMachine, healthy: Trial
) -> None:
    with pytest.raises(GapError, match=r"reaches .* another unit or another robot's joint"):
        machine.observe(replace(healthy, shaft_rad=1000.0 * healthy.shaft_rad))
    with pytest.raises(GapError, match=r'samples lie 10 s apart.*unit = "ms"'):
        machine.observe(replace(healthy, time_s=1000.0 * healthy.time_s))
    endless = healthy.header.robot_text.replace('range="-180 180"', "")
    header = replace(healthy.header, robot_text=endless)
    degrees = replace(healthy, header=header, shaft_rad=np.degrees(healthy.shaft_rad))
    unlimited = make_machine([degrees])
    with pytest.raises(GapError, match=r'rad/s for a tenth of the time.*unit = "deg"'):
        unlimited.observe(degrees)
    heavy = re.sub(r'mass="([0-9.]+)"', r'mass="\1e3"', healthy.header.robot_text)
    grams = replace(healthy, header=replace(healthy.header, robot_text=heavy))
    too_heavy = make_machine([grams])
    with pytest.raises(GapError, match=r"the model needs .* masses in g"):
        too_heavy.observe(grams)
    with pytest.raises(GapError, match="command_upper_rad is empty"):
        machine.observe(replace(healthy, command_rad=np.full_like(healthy.command_rad, np.nan)))


def test_gains_of_the_log_are_taken_and_a_joint_of_the_table_wins(healthy: Trial) -> None:
    header = replace(healthy.header, drive="[joint.fore]\nkp_nm_rad = 7.0",
                     constants=(("kp", (40.0, 30.0)), ("kd", (1.5,))))  # fmt: skip
    drive = make_machine([replace(healthy, header=header)]).parts.drive
    assert [(p.kp, p.kd) for p in drive.joints] == [(40.0, 1.5), (7.0, 1.5)]


def test_a_register_of_a_servo_is_a_stiffness() -> None:
    """P gain 400 with the manual's divisor: 2.302 duty a radian, times stall torque."""
    t, command = chirps(2.0, joints=1)
    motor = """kind = "firmware"
        p_gain = 400
        supply_v = 5.0
        torque_constant_nm_a = 0.354
        resistance_ohm = 3.4"""
    xml = TWO_TREES
    trial = log_of(
        xml, motor, {"time_s": t, "command_rad": command, "shaft_rad": 0.9 * command}, ("a",)
    )
    machine = make_machine([trial])
    assert machine.parts.drive.joints[0].kp == pytest.approx(4 * 0.5755, rel=1e-3)
    assert machine.parts.rigid.welded == ("b",)
    end = machine.predict(trial, (), Drive.COMMAND)
    assert np.isfinite(end).all()


def test_mujoco_is_not_told_to_change_the_file(machine: MjcfMachine, healthy: Trial) -> None:
    before = mujoco.MjModel.from_xml_string(arm())
    machine.predict(healthy, (Cause("body_mass", ("fore",), (2.0,)),), Drive.COMMAND)
    assert np.array_equal(machine.parts.rigid.model.body_mass, before.body_mass)


@pytest.mark.parametrize("own", ["", 'stiffness="8" springref="20" damping="0.3"'])
def test_a_loop_without_a_limit_is_the_spring_that_an_actuator_would_be(own: str) -> None:
    """The same loop with a limit that it never reaches goes through actuators and all bodies."""
    t, command = chirps(3.0)
    foot = '<body pos="0 0 -0.2"><inertial pos="0 0 0" mass="0.1" diaginertia="1e-5 1e-5 1e-5"/></body>'
    xml = arm(upper=own).replace("</body></body>", f"{foot}</body></body>")
    columns = {"time_s": t, "command_rad": command, "shaft_rad": command}
    free, limited = (
        make_machine([log_of(xml, drive, columns)])
        for drive in (LOOP, LOOP + "torque_limit_nm = 1e6\n")
    )
    bodies = 3  # the world and two links; the foot is one with the second
    assert free.parts.rigid.lean.nbody == bodies
    trial = log_of(xml, LOOP, columns)
    causes: tuple[tuple[Cause, ...], ...] = (
        (),
        (Cause("coulomb_friction", ("fore",), (0.3,)), Cause("armature", ("upper",), (0.05,))),
        (Cause("gravity_direction", (), (0.1, -0.2)),),
        (Cause("encoder_offset", ("fore",), (0.05,)), Cause("command_delay", (), (0.03,))),
    )
    for causes_ in causes:
        for drive in Drive:
            lean, whole = (one.predict(trial, causes_, drive) for one in (free, limited))
            assert np.allclose(lean, whole, rtol=0.0, atol=1e-7)
    assert np.ptp(free.predict(trial, causes[1], Drive.COMMAND)) > 0.1
