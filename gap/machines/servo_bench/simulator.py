"""Position-controlled servos, each on its own, as a simulator under diagnosis.

Where the machine's file gives motor data, each servo is a firmware position loop, a DC motor, gearbox
friction and a pendulum; where it does not, the shaft goes where it is commanded.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from gap.constants import SETTLE_S
from gap.data.check import check_trial
from gap.data.even_grid import EvenTrial, even_trial
from gap.data.gait_phase import gait_cycle
from gap.interfaces import Cause, Channel, DataFault, Drive, Effect, Observation, check_causes
from gap.machine_kinds import MachineKind
from gap.machines.servo_bench import kernel as k
from gap.machines.servo_bench.catalogue import (
    ANY,
    BY_NAME,
    CATALOGUE,
    IDEAL,
    MOTOR,
    STAGES,
    added,
    with_alike,
)
from gap.machines.servo_bench.check import believable, check_bench
from gap.machines.servo_bench.kernel import UNLIMITED_RAD_S, ServoNumbers
from gap.machines.servo_bench.machine import ServoJoint, nominal_servos, with_causes
from gap.machines.servo_bench.motions import propose_motions
from model.effects.causes import at_every_joint, joint_by_joint
from model.motion.filters import at_times, lagged, play
from model.values.arrays import FloatArray, readonly
from model.values.gravity import STANDARD_GRAVITY
from record.trial.trial import Trial

TRIALS_REMEMBERED = 128
ASSUMED_SHAFT_RAD = 0.0015  # one count of 4096
ASSUMED_DUTY = 0.01
ASSUMED_CURRENT_A = 0.02


class ServoBench:
    """Implements ``gap.interfaces.Simulator`` for nominal servos.

    Args:
        servos: The nominal servos.
        torque_known: Whether the trials have a signed torque at the shafts.
        logged: Which of the fields ``pwm`` and ``current_a`` the trials have.
    """

    name = "servo_bench"
    stages = STAGES
    bodies: tuple[str, ...] = ()

    def __init__(
        self,
        servos: tuple[ServoJoint, ...],
        torque_known: bool = False,
        logged: frozenset[str] = frozenset({"pwm", "current_a"}),
    ) -> None:
        self.servos = servos
        kinds = {IDEAL if joint.ideal else MOTOR for joint in servos} | {ANY}
        loaded = torque_known or any(joint.numbers.load_kg_m > 0 for joint in servos)
        lacking = "no load" if loaded else "torque"
        self.joints = tuple(joint.name for joint in servos)
        of_one = tuple(
            with_alike(one, logged)
            for one in CATALOGUE
            if one.servos in kinds and one.needs != lacking
        )
        several = self.joints if len(self.joints) > 1 else ()
        of_all = tuple(at_every_joint(one, several) for one in of_one if several)
        self.effects: tuple[Effect, ...] = (*of_one, *of_all)
        self._by_name = {effect.name: effect for effect in self.effects}
        motors = tuple(joint.name for joint in servos if not joint.ideal)
        self.channels = (
            *(Channel("shaft_error", name, "load", "rad") for name in self.joints),
            *(Channel("duty", name, "controller", "") for name in motors),
            *(Channel("current", name, "motor", "A") for name in motors),
        )
        self._compared = frozenset({
            "time_s", "shaft",
            *(f"{what}_{joint.name}_rad" for joint in servos for what in ("command", "shaft")),
            *(f"torque_{joint.name}_nm" for joint in servos if torque_known),
            *(f"{what}_{joint.name}{unit}" for joint in servos if not joint.ideal
              for what, unit in (("pwm", ""), ("current", "_a"))),
        })  # fmt: skip
        self._grid = lru_cache(maxsize=TRIALS_REMEMBERED)(even_trial)

    def observe(self, trial: Trial) -> Observation:
        """Put the measured data of a trial on the channels.

        Raises:
            GapError: It is another machine's, or too short.
        """
        even = self._grid(trial)
        motors = [i for i, joint in enumerate(self.servos) if not joint.ideal]
        values = np.column_stack(
            [even.shaft_rad - even.command_rad, even.pwm[:, motors], even.current_a[:, motors]]
        )
        shaft = trial.header.noise.shaft_rad
        shaft = shaft if np.isfinite(shaft) and shaft > 0 else ASSUMED_SHAFT_RAD
        hz = trial.header.frequency_hz
        noise = np.concatenate([
            np.full(len(self.joints), shaft),
            np.full(len(motors), ASSUMED_DUTY),
            np.full(len(motors), ASSUMED_CURRENT_A),
        ])  # fmt: skip
        weight = np.ones(values.shape)
        weight[even.time_s < SETTLE_S] = 0.0
        for at, joint in enumerate(self.servos):
            if joint.ideal and joint.numbers.coulomb_nm > 0.0:
                # a shaft that nothing pushes past its friction may lie anywhere in its play
                weight[np.abs(even.torque_nm[:, at]) <= joint.numbers.coulomb_nm, at] = 0.0
        return Observation(
            time_s=readonly(even.time_s.copy()),
            cycle=readonly(
                gait_cycle(even.time_s, even.command_rad, even.shaft_rad, hz, cranks=False)
            ),
            values=readonly(values),
            noise=readonly(np.broadcast_to(noise, values.shape).copy()),
            weight=readonly(weight),
        )

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read with these causes added, (F, C).

        Both drives give the same shaft (its loop cannot be cut open); duty and current are fed with the
        measured shaft where that is asked for.

        Raises:
            GapError: A cause is not of the catalogue, or its joints or values do not fit.
        """
        check_causes(causes, self)
        causes = [
            single for one in causes for single in joint_by_joint(one, self._by_name[one.effect])
        ]
        even = self._grid(trial)
        shafts, duties, currents = [], [], []
        for at, joint in enumerate(self.servos):
            numbers = joint.numbers
            for cause in causes:
                if joint.name in cause.joints:
                    numbers = added(numbers, BY_NAME[cause.effect], cause.values)
            ran = _run(even, at, joint, numbers)
            shafts.append(ran[:, 0] - even.command_rad[:, at])
            if joint.ideal:
                continue
            if drive is Drive.MEASURED:
                ran = _local(even, at, joint, numbers, ran)
            duties.append(ran[:, 1])
            currents.append(ran[:, 2])
        predicted: FloatArray = readonly(np.column_stack([*shafts, *duties, *currents]))
        return predicted

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Look for faults of the data themselves."""
        faults = [believable(fault, trial, self._compared) for fault in check_trial(trial)]
        known = tuple(fault for fault in faults if fault is not None)
        seen = {(fault.kind, fault.channel) for fault in known}
        return (*known, *(f for f in check_bench(trial) if (f.kind, f.channel) not in seen))


def _target(
    even: EvenTrial, at: int, joint: ServoJoint, p: ServoNumbers, start: float
) -> FloatArray:
    """Where a position loop wants its shaft, (F,): late, lagging, in its play."""
    target = at_times(even.time_s, even.command_rad[:, at], even.time_s - p.delay_s)
    if joint.ideal and p.speed_limit_rad_s < UNLIMITED_RAD_S:
        target = k.speed_limited(target, p.speed_limit_rad_s, even.period_s)
    return play(lagged(target, p.lag_s, even.period_s), p.play_rad, start)


def _run(even: EvenTrial, at: int, joint: ServoJoint, p: ServoNumbers) -> FloatArray:
    """Run one servo from its commands, (F, 3): reported shaft angle, duty, current."""
    first, command = float(even.shaft_rad[0, at]), float(even.command_rad[0, at])
    start = first if np.isfinite(first) else command
    target = _target(even, at, joint, p, _undrooped(start, command, p))
    torque = even.torque_nm[:, at]
    if joint.ideal:
        out = np.full((len(target), 3), np.nan)
        out[:, 0] = target
    else:
        out = k.run_motor(target, even.period_s, start, 0.0, p)
    gravity = -p.load_kg_m * STANDARD_GRAVITY * np.sin(out[:, 0])
    load = np.where(np.isfinite(torque), torque, gravity)
    out[:, 0] += p.droop_rad_nm * load
    if joint.ideal:
        out[:, 0] += 0.5 * p.backlash_rad * k.pushed_side(load, p.break_nm)
        out[:, 0] += p.droop_sin_rad * np.sin(target) + p.droop_cos_rad * np.cos(target)
    out[:, 0] = p.encoder_scale * out[:, 0] + p.encoder_offset_rad
    return out


def _undrooped(reported: float, command: float, p: ServoNumbers) -> float:
    """Where a shaft lies in its play: what it reports without offset and droop."""
    bent = p.droop_sin_rad * np.sin(command) + p.droop_cos_rad * np.cos(command)
    return float((reported - p.encoder_offset_rad) / p.encoder_scale - bent)


def _local(
    even: EvenTrial, at: int, joint: ServoJoint, p: ServoNumbers, ran: FloatArray
) -> FloatArray:
    """Duty from the measured shaft, current from the measured duty and speed, where they are known."""
    out = ran.copy()
    shaft, first = even.shaft_rad[:, at], float(even.shaft_rad[0, at])
    if p.ki == 0.0:  # an integral's state before the trial is not known
        start = first if np.isfinite(first) else float(even.command_rad[0, at])
        error = _target(even, at, joint, p, start)
        error = error - (shaft - p.encoder_offset_rad) / p.encoder_scale
        duty = p.kp_duty_per_rad * error + p.kd * np.gradient(error, even.period_s)
        out[:, 1] = np.clip(duty, -p.duty_limit, p.duty_limit)
    pwm, speed = even.pwm[:, at], np.gradient(shaft, even.period_s)
    duty = np.where(np.isfinite(pwm), pwm, out[:, 1])
    out[:, 2] = (duty * p.supply_v - p.torque_constant_nm_a * speed) / p.resistance_ohm
    return out


def servo_bench(trials: Sequence[Trial]) -> ServoBench:
    """Return the simulator of the servos that the trials name.

    Raises:
        GapError: Their machine's file does not describe servos.
    """
    signed = any(bool(np.nanmin(t.torque_nm, initial=0.0) < 0.0) for t in trials)
    logged = frozenset(
        name
        for name in ("pwm", "current_a")
        if any(bool(np.isfinite(getattr(one, name)).any()) for one in trials)
    )
    return ServoBench(nominal_servos(trials[0]), signed, logged)


BENCH = MachineKind(servo_bench, apply=with_causes, propose=propose_motions)
