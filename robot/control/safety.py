"""The safety gate: the only producer of what the servo bus sends, and the watch over the servos.

Both are pure. The gate never bends a command: it lets it through whole or refuses it with a reason,
because a clamp that does not report hides a mistake. What is refused does not go out: the bus then gets
the last command once more. The watch turns readings into faults.

Two things reach the servos that are no command of a plan. Each needs an ``Allowed``, and each holds a
shaft where it was measured: the first command with torque switches torque on there
(``ServoBus.torque_on``), and a leg in ``Allowed.recover`` is brought back there (``ServoRecovery``).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite

import numpy as np

from drivers.dynamixel.registers import hardware_error_names
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import EXTENDED_POSITION_LIMIT, TICK_RAD, TICKS_PER_TURN
from model.values.arrays import BoolArray, IntArray, readonly
from model.values.faults import Fault, FaultKind
from model.values.legs import JointCommand, JointState
from model.values.quick import quick
from model.values.readings import ServoReadings
from model.values.tick import LoopTiming
from robot.config.servo import SafetyLimits

# A command may be this much faster than the limit: the grid of ticks and encoder counts is coarse.
SPEED_SLACK = 1.05
# A command older than the servos' watchdog and this is no basis for the next one: they have stopped.
STALE_SLACK_NS = 10_000_000
# A gap this long between two ticks is reported even if the next one came on time.
LONG_GAP_S = 0.05
# Keep clear of the end of the servo's extended position range (+-256 turns).
LAST_TICK = EXTENDED_POSITION_LIMIT - 2 * TICKS_PER_TURN
# From here on a walk is ended: legs that come down turn by another one at most.
ENDING_TICK = LAST_TICK - 2 * TICKS_PER_TURN


@quick
@dataclass(frozen=True, slots=True)
class Allowed:
    """The command may go to the bus as it is.

    Attributes:
        command: The command.
        recover: Legs whose servos may be brought back now, where they stand.
    """

    command: JointCommand
    recover: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Refused:
    """The command may not go to the bus.

    Attributes:
        reason: Why, with leg and figures.
    """

    reason: str


def gate(
    wished: JointCommand,
    last: JointCommand,
    limits: SafetyLimits,
    bus: ServoBusSettings,
    recover: tuple[int, ...] = (),
    refused_ns: int | None = None,
) -> Allowed | Refused:
    """Decide whether a command may go to the servos.

    Args:
        wished: The command asked for.
        last: The command last let through; its angles are the goals that the servos have.
        limits: Safety limits.
        bus: How the servos are mounted; needed for the range of their counters.
        recover: Legs whose servos are to be brought back (``robot.control.recovery`` decides which).
        refused_ns: If the command before was refused: when. A jump that was refused does not become
            slow enough by being asked for again and again.

    Returns:
        ``Allowed`` with the same command, or ``Refused``. A command without torque is always allowed, and
        brings nothing back.
    """
    if not wished.torque:
        return Allowed(wished)
    angles = wished.angle_rad.tolist()
    if not isfinite(sum(angles) + sum(wished.rate_rad_s.tolist())):
        known = np.isfinite(wished.angle_rad) & np.isfinite(wished.rate_rad_s)
        return Refused(f"{_legs(bus, ~known)}: the command is not a number")
    elapsed_ns = wished.t_ns - last.t_ns
    if elapsed_ns <= 0 and last.torque:
        return Refused("the command is not newer than the one before")
    if elapsed_ns > bus.watchdog_s * 1e9 + STALE_SLACK_NS and last.torque:
        return Refused(
            f"the command before is {elapsed_ns * 1e-6:.0f} ms old; the loop stood still"
        )
    mounted = zip(bus.zeros.tolist(), bus.signs.tolist(), angles, strict=True)
    beyond = [abs(zero + sign * angle / TICK_RAD) > LAST_TICK for zero, sign, angle in mounted]
    if True in beyond:
        return Refused(
            f"{_legs(bus, beyond)}: the servo's turn counter is used up (256 turns); "
            "stop, cut torque and start again to set it back"
        )
    if refused_ns is not None:
        elapsed_ns = wished.t_ns - refused_ns
    allowed_rad = limits.max_speed_rad_s * SPEED_SLACK * elapsed_ns * 1e-9
    allowed_rad += TICK_RAD
    step_rad = [abs(to - at) for to, at in zip(angles, last.angle_rad.tolist(), strict=True)]
    if True in [step > allowed_rad for step in step_rad]:
        worst = int(np.nanargmax(step_rad))
        return Refused(
            f"{bus.names[worst]}: a step of {step_rad[worst]:.3f} rad in "
            f"{elapsed_ns * 1e-6:.0f} ms is faster than {limits.max_speed_rad_s:g} rad/s"
        )
    return Allowed(wished, recover)


def _legs(bus: ServoBusSettings, where: Iterable[bool]) -> str:
    return " ".join(name for name, here in zip(bus.names, where, strict=True) if here)


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ServoVerdict:
    """The verdict of the watch over the servos in one tick.

    Attributes:
        faults: Faults, in words.
        silent_reads: Reads in a row without an answer, (N,) int64.
        lost_legs: Servos that have been silent for too long, (N,) bool.
        broken_legs: Servos that report a hardware error, are too hot, draw too much or have too little
            voltage, for long enough to be trusted, (N,) bool.
        bad_reads: Reads in a row in which some value was beyond its limit, (N,) int64.
    """

    faults: tuple[Fault, ...]
    silent_reads: IntArray
    lost_legs: BoolArray
    broken_legs: BoolArray
    bad_reads: IntArray

    @staticmethod
    @cache
    def sound(count: int) -> "ServoVerdict":
        """Return the verdict on so many servos that are all well, as in nearly every tick."""
        none = readonly(np.zeros(count, dtype=np.int64))
        nobody = readonly(np.zeros(count, dtype=bool))
        return ServoVerdict((), none, nobody, nobody, none)


# Readings beyond a limit must persist: one noisy current sample is no fault worth a stop.
PERSISTENCE_READS = 10
ALERT_BIT = 0x80  # of a status packet's error byte, its highest


def watch_servos(
    readings: ServoReadings,
    joints: JointState,
    sent: JointCommand,
    before: ServoVerdict,
    limits: SafetyLimits,
    bus: ServoBusSettings,
) -> ServoVerdict:
    """Compare one set of readings with the limits.

    Args:
        readings: Raw readings (validity, error bytes).
        joints: The same, calibrated.
        sent: The command the servos were following.
        before: The verdict of the tick before.
        limits: Safety limits.
        bus: Names and the number of silent reads allowed.
    """
    if _all_well(readings, joints, sent, limits):
        return ServoVerdict.sound(len(bus.names))
    faults: list[Fault] = []
    silent = np.where(readings.valid, 0, before.silent_reads + 1)
    bad = np.zeros(readings.valid.shape, dtype=bool)
    error = np.where(readings.hardware_error > 0, readings.hardware_error, 0)
    alert = readings.valid & (((readings.error_byte & ALERT_BIT) != 0) | (error != 0))
    lag = np.abs(joints.angle_rad - sent.angle_rad) if sent.torque else np.zeros_like(bad, float)
    checks = (
        (FaultKind.SERVO_HOT, joints.temperature_c, limits.max_temperature_c, 1, "degC"),
        (FaultKind.SERVO_CURRENT, np.abs(joints.current_a), limits.max_current_a, 1, "A"),
        (FaultKind.SERVO_VOLTAGE, joints.voltage_v, limits.min_voltage_v, -1, "V"),
        (FaultKind.SERVO_LAG, lag, limits.max_following_error_rad, 1, "rad"),
    )
    for leg, name in enumerate(bus.names):
        if not readings.valid[leg]:
            faults.append(
                Fault(FaultKind.SERVO_SILENT, name, f"no sound answer for {silent[leg]} reads")
            )
            continue
        if alert[leg]:
            faults.append(Fault(FaultKind.SERVO_ALERT, name, _hardware_error_words(error[leg])))
    for kind, values, limit, sense, unit in checks:
        beyond = readings.valid & (sense * (values - limit) > 0)
        bad |= beyond
        for leg in np.flatnonzero(beyond).tolist():
            detail = f"{values[leg]:.3g} {unit}, limit {limit:g} {unit}"
            faults.append(Fault(kind, bus.names[leg], detail))
    still = np.where(readings.valid, 0, before.bad_reads)
    bad_now = np.where(bad, before.bad_reads + 1, still)
    return ServoVerdict(
        faults=tuple(faults),
        silent_reads=silent,
        lost_legs=silent >= bus.silent_limit,
        broken_legs=alert | (bad_now >= PERSISTENCE_READS),
        bad_reads=bad_now,
    )


def watch_turns(
    readings: ServoReadings, sent: JointCommand, names: Sequence[str]
) -> tuple[Fault, ...]:
    """Tell of servos whose turn counters are nearly used up, while there is time to end a walk on all feet.

    Args:
        readings: Raw readings.
        sent: The command the servos were following; without torque nothing turns on.
        names: Of the servos.
    """
    ticks = readings.position_ticks.tolist()
    if not sent.torque or (max(ticks) <= ENDING_TICK and min(ticks) >= -ENDING_TICK):
        return ()
    return tuple(
        Fault(FaultKind.TURNS_USED, name, f"{abs(tick) / TICKS_PER_TURN:.0f} of 256 turns are used")
        for name, tick, known in zip(names, ticks, readings.valid.tolist(), strict=True)
        if known and abs(tick) > ENDING_TICK
    )


def watch_timing(
    timing: LoopTiming, late: int, period_ns: int, late_limit_s: float
) -> tuple[int, tuple[Fault, ...]]:
    """Return the late ticks in a row, and a fault if this one is late.

    Args:
        timing: Of the loop.
        late: Late ticks in a row before this one.
        period_ns: Period of the loop.
        late_limit_s: How late a tick may be.
    """
    late_s = timing.lateness_ns * 1e-9
    stood_still_s = timing.missed * period_ns * 1e-9
    if stood_still_s >= LONG_GAP_S:
        detail = f"the loop was stopped for {stood_still_s * 1e3:.0f} ms"
        return late + 1, (Fault(FaultKind.LATE, "loop", detail),)
    if late_s <= late_limit_s:
        return 0, ()
    return late + 1, (Fault(FaultKind.LATE, "loop", f"{late_s * 1e3:.1f} ms late"),)


def _all_well(
    readings: ServoReadings, joints: JointState, sent: JointCommand, limits: SafetyLimits
) -> bool:
    """Whether every servo has answered and nothing is beyond its limit, as in nearly every tick.

    Six numbers are checked sooner as a list; where one is NaN the answer is no, but for a current that its
    servo does not measure: it is not judged.
    """
    lags = (joints.angle_rad - sent.angle_rad if sent.torque else np.zeros(1)).tolist()
    hot_c, volts = joints.temperature_c.tolist(), joints.voltage_v.tolist()
    return (
        all(readings.valid.tolist())
        and max(readings.error_byte.tolist()) < ALERT_BIT
        and max(readings.hardware_error.tolist()) <= 0
        and isfinite(sum(hot_c) + sum(volts) + sum(lags))
        and max(hot_c) <= limits.max_temperature_c
        and not any(abs(a) > limits.max_current_a for a in joints.current_a.tolist())
        and min(volts) >= limits.min_voltage_v
        and max(map(abs, lags)) <= limits.max_following_error_rad
    )


def _hardware_error_words(error: int) -> str:
    names = hardware_error_names(int(error))
    return "hardware error: " + (", ".join(names) if names else "alert bit set, cause not read yet")
