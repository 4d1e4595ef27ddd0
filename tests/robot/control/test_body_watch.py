"""The watch over body and shafts: each limit by itself, and on the whole loop with a scripted fault."""

from dataclasses import replace

import numpy as np
import pytest

from model.errors import ConfigError
from model.values.contact import ContactSolution, Support, Traction
from model.values.faults import Fault, FaultKind, StopReason
from model.values.legs import FootForces, JointCommand, JointState
from model.values.tick import DeadReckoning, Mode
from robot.config.safety import BodyLimits
from robot.control.body_watch import BodyInputs, BodyMemory, watch_body
from robot.control.stops import stop_at_once
from tests.robot.bench_runs import bench_run, changed
from tests.robot.runs import CONFIG

NAMES = CONFIG.servo_bus.names
PERIOD_NS = 10_000_000
LIMITS = BodyLimits()
NO_FAULTS: tuple[Fault, ...] = ()
STUCK = '[[fault]]\nkind = "stuck_shaft"\nservo = 1\nstart_s = 2.2\n'


def known(t_ns: int = PERIOD_NS, **more: object) -> BodyInputs:
    angle = np.zeros(6)
    nan3, nan62, nan63 = np.full(3, np.nan), np.full((6, 2), np.nan), np.full((6, 3), np.nan)
    force = np.tile([0.0, 0.0, 10.0], (6, 1))
    usual = BodyInputs(
        t_ns=t_ns,
        mode=Mode.WALK,
        joints=JointState(t_ns, angle, angle, angle, angle, angle, angle, np.ones(6, dtype=bool)),
        sent=JointCommand(t_ns, angle, angle, torque=True),
        forces=FootForces(t_ns, force, np.ones(6, dtype=bool)),
        contact=ContactSolution(
            Support(True, "", 0.1, 0.0, 0.0, np.full(6, 10.0), np.ones(6, dtype=bool), 0),
            Traction(False, "", nan3, nan62, nan63),
        ),
        dead_reckoning=DeadReckoning(t_ns, np.zeros(2), 0.0, np.zeros(3), valid=True),
        weight_n=60.0,
        sensors=(True,) * 6,
        down=np.zeros(6, dtype=bool),
    )
    return replace(usual, **more)  # type: ignore[arg-type]


def watch(shown: BodyInputs, seconds: float, limits: BodyLimits = LIMITS) -> set[FaultKind]:
    """Show the same thing for so long."""
    memory, faults = BodyMemory.empty(6), NO_FAULTS
    for n in range(1 + round(seconds / 0.01)):
        now = replace(shown, t_ns=(n + 1) * PERIOD_NS)
        memory, faults = watch_body(memory, now, limits, NAMES)
    return {fault.kind for fault in faults}


def leaning(slope: float) -> BodyInputs:
    whole = known().contact
    return known(contact=replace(whole, support=replace(whole.support, slope_x=slope)))


def test_a_sound_robot_has_no_fault() -> None:
    assert watch(known(), 2.0) == set()


@pytest.mark.parametrize(
    ("slope", "seconds", "found"), [(0.3, 1.0, False), (0.5, 0.15, False), (0.5, 0.25, True)]
)
def test_a_lean_by_the_model_must_last(slope: float, seconds: float, found: bool) -> None:
    assert (FaultKind.TILTED in watch(leaning(slope), seconds)) is found


def test_a_lean_by_the_measured_forces() -> None:
    force = np.tile([4.0, 0.0, 9.0], (6, 1))
    forces = FootForces(0, force, np.ones(6, dtype=bool))
    assert watch(known(forces=forces), 0.3) == {FaultKind.TILTED}
    one_missing = FootForces(0, force, np.array([True] * 5 + [False]))
    assert watch(known(forces=one_missing), 0.3) == set(), "nothing is judged from what is absent"


def test_feet_that_carry_nothing() -> None:
    forces = FootForces(0, np.full((6, 3), 0.5), np.ones(6, dtype=bool))
    assert watch(known(forces=forces), 0.2) == set()
    assert watch(known(forces=forces), 0.4) == {FaultKind.UNLOADED}
    assert watch(known(forces=forces, sensors=(True,) * 5 + (False,)), 0.4) == set()


def stalled(current_a: float, follows: float) -> set[FaultKind]:
    """A goal at 0.35 rad/s for a second, and a shaft that turns a share of it."""
    memory, faults = BodyMemory.empty(6), NO_FAULTS
    for n in range(100):
        angle = np.zeros(6)
        angle[2] = 0.0035 * n
        shaft, amps = follows * angle, np.zeros(6)
        amps[2] = current_a
        base = known((n + 1) * PERIOD_NS)
        now = replace(
            base,
            joints=replace(base.joints, angle_rad=shaft, current_a=amps),
            sent=replace(base.sent, angle_rad=angle),
        )
        memory, faults = watch_body(memory, now, LIMITS, NAMES)
    return {fault.kind for fault in faults}


@pytest.mark.parametrize(
    ("current_a", "follows", "found"), [(3.0, 0.05, True), (3.0, 0.9, False), (0.3, 0.05, False)]
)
def test_a_stall_is_no_travel_with_much_current(
    current_a: float, follows: float, found: bool
) -> None:
    assert (FaultKind.SERVO_STALLED in stalled(current_a, follows)) is found


def moved(mode: Mode, moved_m: float, limits: BodyLimits = LIMITS) -> set[FaultKind]:
    memory, _ = watch_body(BodyMemory.empty(6), known(mode=mode), limits, NAMES)
    there = DeadReckoning(0, np.array([moved_m, 0.0]), 0.0, np.zeros(3), valid=True)
    now = known(2 * PERIOD_NS, mode=mode, dead_reckoning=there)
    _, faults = watch_body(memory, now, limits, NAMES)
    return {fault.kind for fault in faults}


def test_slipping_away_while_it_should_stand() -> None:
    assert moved(Mode.HOLD, 0.06) == {FaultKind.SLIPPED}
    assert moved(Mode.HOLD, 0.04) == set()
    assert moved(Mode.WALK, 1.0) == set(), "walking is not slipping"


def test_too_far_from_where_it_began() -> None:
    assert moved(Mode.WALK, 1.1, replace(LIMITS, max_distance=1.0)) == {FaultKind.SLIPPED}


def test_without_torque_nothing_is_judged() -> None:
    limp = replace(leaning(1.0), sent=replace(known().sent, torque=False))
    assert watch(limp, 1.0) == set()


def test_every_fault_has_its_reason() -> None:
    _, faults = watch_body(
        replace(BodyMemory.empty(6), t_ns=0, unloaded_s=1.0),
        known(forces=FootForces(0, np.zeros((6, 3)), np.ones(6, dtype=bool))),
        LIMITS,
        NAMES,
    )
    assert stop_at_once(faults) is StopReason.UNLOADED
    assert stop_at_once(()) is StopReason.NONE


# On the whole loop.


def test_a_robot_that_hangs_stops_and_says_so() -> None:
    done = bench_run(weight_n=5.0)
    assert done.result.reason is StopReason.UNLOADED
    assert "all feet together carry" in done.result.detail
    assert done.result.torque_off
    assert done.ticks[-1].mode is Mode.HOLD


def test_a_jammed_shaft_is_a_stall() -> None:
    """Limits on current and lag put away, so that the stall is what is left."""
    config = changed({"max_current = 4.0 ": "max_current = 6.8 ",
                      "max_following_error = 0.6 ": "max_following_error = 3.1 "})  # fmt: skip
    done = bench_run(STUCK, config=config)
    assert done.result.reason is StopReason.SERVO_STALLED
    assert done.result.detail.startswith("HL: its goal moved")
    at_s, _ = done.first(FaultKind.SERVO_STALLED)
    assert 2.2 < at_s < 3.5


def test_a_fence_around_the_beginning() -> None:
    done = bench_run(config=changed(more="[safety]\nmax_distance = 0.02"), seconds=20.0)
    assert done.result.reason is StopReason.SLIPPED
    assert "from where it began, limit 0.02 m" in done.result.detail


def test_a_tilt_limit_below_the_ordinary_stops_the_walk() -> None:
    done = bench_run(config=changed(more="[safety]\nmax_tilt = 0.002"), seconds=20.0)
    assert done.result.reason is StopReason.TILTED
    assert "by the model's support" in done.result.detail


# The robot file.


def test_the_table_may_be_left_out_or_in_part() -> None:
    assert CONFIG.body_limits == BodyLimits()
    config = changed(more="[safety]\nmax_slip = 0.1")
    assert config.body_limits == replace(BodyLimits(), max_slip=0.1)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("[safety]\nmax_tild = 0.1", "did you mean 'max_tilt'"),
        ("[safety]\nmax_tilt = 0", "must be above 0"),
        ("[safety]\nmin_load = 1.5", "must be at most 0.95"),
        ("[safety.recovery]\nwindow = 3", "is missing"),
        (
            '[safety.recovery]\nmost = 1\ncauses = ["heat"]',
            "'heat' is no hardware error; there are",
        ),
        ("[safety.recovery]\nmost = 1\nafter_restart = 1", "must be true or false"),
    ],
)
def test_wrong_keys_are_named(more: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        changed(more=more)
