"""A few shafts moved before any gait: torque on where they stand, every goal through the safety gate.

The watch over the servos is the controller's own (``robot.control.safety``). The torque goes off however
the block is left, and no Ctrl-C cuts that short.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.joints import joint_state
from drivers.dynamixel.settings import ServoBusSettings
from gaits.plan import Plan
from model.errors import BusError
from model.values.arrays import FloatArray, IntArray
from model.values.legs import JointCommand, JointState
from robot.config.robot_file import RobotConfig
from robot.control.safety import Refused, ServoVerdict, gate, watch_servos
from robot.run.operator import Interrupts


class TorqueStillOn(BusError):  # noqa: N818 - it is a state, and reads as one
    """Torque has been switched off and a servo did not confirm it."""

    def __init__(self) -> None:
        super().__init__("TORQUE NOT CONFIRMED OFF: cut the power")


@contextmanager
def limp_afterwards(bus: ServoBus) -> Iterator[None]:
    """Switch torque off when the block is left, whatever the reason; signals wait meanwhile.

    Raises:
        TorqueStillOn: A servo did not confirm that its torque is off.
        KeyboardInterrupt: A signal came while torque was being switched off.
    """
    try:
        yield
    finally:
        with Interrupts() as late:
            late.begin()
            off = bus.torque_off()
        if not off:
            raise TorqueStillOn
    if late.count:
        raise KeyboardInterrupt


def leg_settings(settings: ServoBusSettings, leg: int) -> ServoBusSettings:
    """Return the bus of one leg alone: the others are neither asked nor switched on."""
    one = slice(leg, leg + 1)
    return replace(
        settings,
        names=settings.names[one],
        ids=settings.ids[one],
        signs=settings.signs[one],
        models=(settings.models[leg],),
        zeros=settings.zeros[one],
    )


@dataclass(frozen=True, slots=True, eq=False)
class JogTrack:
    """What the shafts did, T ticks of N shafts.

    Attributes:
        t_ns: When each tick began, (T,).
        goal_rad: Goals, (T, N) [rad].
        angle_rad: Angles measured at the beginning of each tick, (T, N) [rad]; NaN where unknown.
        current_a: Currents, (T, N) [A].
    """

    t_ns: IntArray
    goal_rad: FloatArray
    angle_rad: FloatArray
    current_a: FloatArray


class GatedShafts:
    """Shafts with torque on that follow plans.

    Args:
        bus: The bus, connected and configured; torque goes on here.
        config: Limits and rate; its legs may be more than those of the bus.

    Raises:
        BusError: Torque does not go on.
    """

    def __init__(self, bus: ServoBus, config: RobotConfig) -> None:
        self._bus = bus
        self._limits = config.limits
        self._period_ns = round(1e9 / config.loop.rate_hz)
        self._verdict = ServoVerdict.sound(len(bus.settings.names))
        bus.torque_on()
        angle = self._read().angle_rad
        if not np.isfinite(angle).all():
            raise BusError("a servo does not report its position: check its cable")
        self._last = JointCommand(bus.clock.now_ns(), angle, np.zeros_like(angle), torque=True)

    @property
    def angle_rad(self) -> FloatArray:
        """Goals that the shafts have, (N,) [rad]."""
        return self._last.angle_rad

    def _read(self) -> JointState:
        return joint_state(self._bus.read(), self._bus.settings)

    def follow(
        self, plan: Plan, seconds: float, meanwhile: Callable[[float], None] = lambda _: None
    ) -> JogTrack:
        """Follow a plan.

        Args:
            plan: Angles of the bus's shafts over time; it begins where they stand.
            seconds: For so long.
            meanwhile: Called each tick with the seconds so far.

        Raises:
            BusError: The gate refuses a goal, or a servo is lost, faulty or does not follow.
            ConnectionLost: The port is gone.
        """
        bus, clock = self._bus, self._bus.clock
        times, goals, angles, currents = [], [], [], []
        begin_ns = deadline_ns = clock.now_ns()
        while deadline_ns <= begin_ns + seconds * 1e9:
            clock.sleep_until_ns(deadline_ns)
            times.append(clock.now_ns())
            readings = bus.read()
            joints = joint_state(readings, bus.settings)
            self._verdict = watch_servos(
                readings, joints, self._last, self._verdict, self._limits, bus.settings
            )
            if (self._verdict.lost_legs | self._verdict.broken_legs).any():
                raise BusError("; ".join(f"{f.source}: {f.detail}" for f in self._verdict.faults))
            now_ns = clock.now_ns()
            wished = JointCommand(now_ns, *plan.at(now_ns), torque=True)
            allowed = gate(wished, self._last, self._limits, bus.settings)
            if isinstance(allowed, Refused):
                raise BusError(f"the safety gate refuses it: {allowed.reason}")
            bus.write_goals(allowed.command)
            self._last = allowed.command
            goals.append(wished.angle_rad)
            angles.append(joints.angle_rad)
            currents.append(joints.current_a)
            meanwhile((clock.now_ns() - begin_ns) * 1e-9)
            deadline_ns = max(deadline_ns + self._period_ns, clock.now_ns())
        return JogTrack(np.array(times), np.array(goals), np.array(angles), np.array(currents))


def joined_track(tracks: Sequence[JogTrack]) -> JogTrack:
    """Return tracks of the same shafts one behind the other."""
    parts = zip(
        *((one.t_ns, one.goal_rad, one.angle_rad, one.current_a) for one in tracks), strict=True
    )
    return JogTrack(*map(np.concatenate, parts))


def largest(current_a: FloatArray) -> float:
    """Return the largest magnitude of currents [A]; NaN where none is measured."""
    return float(np.fmax.reduce(np.abs(current_a), axis=None))


def current_words(current_a: float) -> str:
    """Return the largest current for a person."""
    return f"at most {current_a:.2f} A" if np.isfinite(current_a) else "current not measured"
