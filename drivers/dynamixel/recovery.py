"""Bounded recovery of a servo that has shut itself down or restarted while the robot runs.

``ServoRecovery`` finds out that a servo has lost its torque, keeps the cause, and may bring it back:
reboot if an error is latched, torque on at the measured position, watchdog armed. It does so only where
the policy allows it, and at most so many times in so long, because a servo that shuts down again and
again protects itself from something real. Nothing here decides that the robot should go on.

A servo that restarts has lost its turns: the same shaft angle has another position afterwards.
``Recovery.zero_shift_ticks`` says by how much; a goal computed without it would unwind those turns, so the
bus is told, and gives and takes positions as if nothing had happened.
"""

import enum
from collections import deque
from dataclasses import dataclass
from functools import partial

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.frames import ALERT
from drivers.dynamixel.reboot import reboot_servo
from drivers.dynamixel.registers import HardwareError, hardware_error_names
from drivers.dynamixel.setup import configure_servo, hold_here
from drivers.dynamixel.units import TICKS_PER_TURN
from drivers.dynamixel.watchdog import TRIPPED
from model.errors import BusError, ConnectionLost
from model.values.readings import ServoReadings

# One servo's torque is asked for in turn, once in so many looks.
POLL_EVERY_LOOKS = 10
NOBODY = -1
# A shaft cannot turn half a turn from one read to the next: its turn count has changed.
JUMP_TICKS = TICKS_PER_TURN // 2


@dataclass(frozen=True, slots=True)
class RecoveryPolicy:
    """What may be recovered from. The default allows nothing.

    Attributes:
        most: Recoveries of all servos together within ``window_s``; 0 forbids them.
        window_s: The time that ``most`` counts in [s].
        causes: Hardware errors that may be rebooted away, all bits of a cause must be among them.
        after_restart: Whether a servo that lost power and restarted may be switched on again.
    """

    most: int = 0
    window_s: float = 300.0
    causes: HardwareError = HardwareError.OVERLOAD
    after_restart: bool = False


class IncidentKind(enum.Enum):
    """How a servo lost its torque."""

    SHUT_DOWN = "shut itself down"
    RESTARTED = "restarted"
    TORQUE_LOST = "lost its torque"
    TRIPPED = "received nothing for its watchdog's time and takes no goals"


@dataclass(frozen=True, slots=True)
class Incident:
    """A servo that lost its torque while it should have it.

    Attributes:
        t_ns: When it was found out.
        index: Leg index.
        leg: Leg name.
        servo_id: Dynamixel id.
        kind: How.
        cause: Hardware error bits; 0 if there are none.
        ticks_before: Last position known before it [ticks].
        ticks_after: Position when it was found out [ticks].
    """

    t_ns: int
    index: int
    leg: str
    servo_id: int
    kind: IncidentKind
    cause: int
    ticks_before: int
    ticks_after: int

    @property
    def words(self) -> str:
        """What happened, for a person."""
        causes = ", ".join(hardware_error_names(self.cause))
        return f"{self.leg} (id {self.servo_id}) {self.kind.value}" + (f": {causes}" * bool(causes))


@dataclass(frozen=True, slots=True)
class Recovery:
    """How an attempt to recover ended.

    Attributes:
        incident: What it was about; the cause is kept here, the servo has forgotten it.
        recovered: True if torque is on again at the measured position.
        reason: Why not, in words; empty if recovered.
        zero_shift_ticks: Turns lost since torque first went on, in ticks: what the bus now takes off the
            leg's positions. 0 if not recovered.
        goal_ticks: Where it holds now [ticks]; 0 if not recovered.
        torque_off: If not recovered: whether the servo confirmed that its torque is off.
    """

    incident: Incident
    recovered: bool
    reason: str
    zero_shift_ticks: int
    goal_ticks: int
    torque_off: bool


class ServoRecovery:
    """Watches one bus. Not for two threads at once.

    Args:
        bus: The bus, with torque switched on by ``torque_on``.
        policy: What is allowed.
    """

    def __init__(self, bus: ServoBus, policy: RecoveryPolicy) -> None:
        self.policy = policy
        self._bus = bus
        self._attempts: deque[int] = deque(maxlen=max(1, policy.most))
        self._looks = 0
        count = len(bus.settings.names)
        self._known, self._ticks = [False] * count, [0] * count
        self._was_valid: list[bool] = [True] * count
        self._alerted = [False] * count
        self._open: set[int] = set()
        self._examine_all = False

    # Finding out.

    def look(self, readings: ServoReadings) -> tuple[Incident, ...]:
        """Look for servos that lost their torque; each is reported once until it is recovered.

        Costs nothing on an ordinary read, three short requests for a servo under suspicion (a new
        alert, a jump of its position, an answer after silence), and one now and then in turn.

        Args:
            readings: What ``ServoBus.read`` just brought.

        Raises:
            ConnectionLost: The port is gone.
        """
        if not self._bus.torque_wanted:
            self._remember(readings)
            return ()
        incidents: list[Incident] = []
        for index in self._suspects(readings):
            incident = self._examine(index, readings)
            if incident is not None:
                incidents.append(incident)
                self._open.add(incident.index)
        self._remember(readings)
        return tuple(incidents)

    def _suspects(self, readings: ServoReadings) -> list[int]:
        """Return the servos to be asked; half a dozen are sooner gone through one by one."""
        self._looks += 1
        turn, rest = divmod(self._looks, POLL_EVERY_LOOKS)
        in_turn = turn % len(self._ticks) if not rest else NOBODY
        every, self._examine_all = self._examine_all, False
        now = zip(
            readings.valid.tolist(), readings.position_ticks.tolist(), readings.error_byte.tolist(),
            strict=True,
        )  # fmt: skip
        return [
            i for i, (valid, ticks, error) in enumerate(now)
            if valid and i not in self._open and (
                every or i == in_turn or not self._was_valid[i]
                or (error & ALERT and not self._alerted[i])
                or (self._known[i] and abs(ticks - self._ticks[i]) > JUMP_TICKS)
            )
        ]  # fmt: skip

    def _remember(self, readings: ServoReadings) -> None:
        self._was_valid = readings.valid.tolist()
        ticks, errors = readings.position_ticks.tolist(), readings.error_byte.tolist()
        for i, valid in enumerate(self._was_valid):
            if valid:
                self._known[i], self._ticks[i] = True, ticks[i]
                self._alerted[i] = bool(errors[i] & ALERT)

    def _examine(self, index: int, readings: ServoReadings) -> Incident | None:
        """Ask one servo for its torque and its watchdog; if there is none or it tripped, for the cause."""
        servo = self._bus.servos()[index]
        try:
            torque = servo.read("torque_enable")
            if torque and servo.read("bus_watchdog") != TRIPPED:
                return None
            cause = servo.read("hardware_error_status")
            mask = servo.read("shutdown")
        except ConnectionLost:
            raise
        except BusError:
            return None  # silent again: the loop counts that, and we look when it is back
        after = int(readings.position_ticks[index])
        before = self._ticks[index] if self._known[index] else after
        if torque:
            kind = IncidentKind.TRIPPED
        elif cause & mask:
            kind = IncidentKind.SHUT_DOWN
        elif abs(after - before) > JUMP_TICKS or not self._was_valid[index]:
            kind = IncidentKind.RESTARTED
        else:
            kind = IncidentKind.TORQUE_LOST
        return Incident(readings.t_ns, index, servo.leg, servo.servo_id, kind, cause, before, after)

    # Bringing it back.

    def refusal(self, incident: Incident) -> str:
        """Return why the policy forbids a recovery now, in words; empty if it allows it."""
        policy = self.policy
        if policy.most <= 0:
            return "recovery is not allowed"
        if incident.cause & ~int(policy.causes):
            names = ", ".join(hardware_error_names(incident.cause & ~int(policy.causes)))
            return f"recovery from {names} is not allowed"
        lost = (IncidentKind.RESTARTED, IncidentKind.TORQUE_LOST)
        if incident.kind in lost and not policy.after_restart:
            return f"recovery of a servo that {incident.kind.value} is not allowed"
        now_ns = self._bus.clock.now_ns()
        recent = [t for t in self._attempts if now_ns - t < policy.window_s * 1e9]
        if len(recent) >= policy.most:
            return f"{len(recent)} recoveries within {policy.window_s:g} s, and that is the limit"
        return ""

    def recover(self, incident: Incident) -> Recovery:
        """Bring one servo back where it stands, if the policy allows it. Blocks while it restarts.

        The others get their last goals again all the while: whether a watchdog counts requests to other
        ids is not known. The next look asks each of them all the same. A failed attempt counts; torque
        of that servo is off afterwards.

        Raises:
            ConnectionLost: The port is gone.
        """
        reason = self.refusal(incident)
        servo = self._bus.servos()[incident.index]
        if reason:
            return _failed(incident, reason, torque_off=_torque_is_off(servo))
        self._attempts.append(self._bus.clock.now_ns())
        try:
            ticks, shift = self._bring_back(servo, incident)
        except ConnectionLost:
            raise
        except BusError as error:
            return _failed(incident, str(error), torque_off=_switch_off(servo))
        finally:
            self._examine_all = True
        self._open.discard(incident.index)
        self._bus.note_restart(incident.index, shift)
        self._ticks[incident.index] = ticks - shift
        self._alerted[incident.index] = False
        return Recovery(incident, True, "", shift, ticks, torque_off=False)

    def _bring_back(self, servo: CheckedServo, incident: Incident) -> tuple[int, int]:
        """Return where the servo holds now and by how much its zero has shifted [ticks]."""
        feed = partial(self._bus.repeat_goals, incident.index)
        feed()
        if incident.kind is IncidentKind.SHUT_DOWN:
            error = reboot_servo(servo, feed).error_after
            if error:
                names = ", ".join(hardware_error_names(error))
                raise servo.error(
                    f"still reports {names} after its reboot", "hardware_error_status"
                )
        if incident.kind is not IncidentKind.TRIPPED:  # that one has kept torque and settings
            configure_servo(servo)
        feed()
        ticks = hold_here(servo)
        servo.write_verified("bus_watchdog", self._bus.watchdog_units)
        feed()
        turns = round((ticks - incident.ticks_before) / TICKS_PER_TURN)
        return ticks, turns * TICKS_PER_TURN


def _failed(incident: Incident, reason: str, *, torque_off: bool) -> Recovery:
    return Recovery(incident, False, reason, 0, 0, torque_off)


def _torque_is_off(servo: CheckedServo) -> bool:
    try:
        return servo.read("torque_enable") == 0
    except BusError:
        return False


def _switch_off(servo: CheckedServo) -> bool:
    """Switch one servo's torque off as well as it can be done."""
    try:
        servo.write_verified("torque_enable", 0)
    except BusError:
        return False
    return True
