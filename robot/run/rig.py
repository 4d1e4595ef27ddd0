"""The robot as the loop sees it: one read, one write, one way to cut torque.

Behind it are the two drivers, whatever is behind those: the real robot, the device process on a
pseudo-terminal and loopback sockets, or virtual devices in memory under a virtual clock.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from drivers.ati.calibration import Calibration
from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream, StreamCounters
from drivers.clock import Clock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.recovery import Incident, RecoveryPolicy, ServoRecovery
from drivers.lines.imu import ImuListener
from drivers.lines.poses import PoseListener
from drivers.wire.tap import WireTap
from model.errors import BusError, ConnectionLost
from model.values.faults import Fault, FaultKind, ServoEvent
from model.values.quick import quick
from model.values.readings import (
    BodyTruth,
    ForceRecord,
    ImuRecord,
    PoseRecord,
    ServoReadings,
    silent_readings,
)
from robot.config.safety import RecoverySettings
from robot.control.safety import Allowed


class TruthSource(Protocol):
    """Something that knows where the body really is: the plant, or motion capture."""

    def latest(self) -> BodyTruth | None:
        """Return the newest truth, None if there is none yet."""
        ...


@quick
@dataclass(frozen=True, slots=True)
class Reading:
    """What one read brought in.

    Attributes:
        servos: Servo readings; all invalid after the link was lost.
        forces: Force records since the last read, oldest first.
        truth: Ground truth, None where there is none.
        faults: Faults the drivers found.
        poses: Absolute poses since the last read.
        servo_events: Servos that lost their torque or were brought back since then; each is a fault too.
        imu: Readings of an inertial unit since the last read.
    """

    servos: ServoReadings
    forces: tuple[ForceRecord, ...]
    truth: BodyTruth | None = None
    faults: tuple[Fault, ...] = ()
    poses: tuple[PoseRecord, ...] = ()
    servo_events: tuple[ServoEvent, ...] = ()
    imu: tuple[ImuRecord, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Wires:
    """What the drivers of one robot are connected to.

    Attributes:
        clock: The clock that all of it lives by.
        port: Port of the servo bus, not yet open.
        unit: Force-torque unit.
        links: Opens both ways to it; None runs without one.
        reopen: Opens its console again beside the loop, untapped; None never does.
        truth: Source of ground truth, or None.
        closers: Called last when the rig closes, in order.
        tap: Listens to the servo port; whoever makes ``links`` taps those.
    """

    clock: Clock
    port: ClockedPort
    unit: ForceSensorSettings
    links: Callable[[], tuple[DatagramLink, TextLink]] | None
    reopen: Callable[[], TextLink] | None = None
    truth: TruthSource | None = None
    closers: tuple[Callable[[], None], ...] = ()
    tap: WireTap | None = None


class Rig:
    """Drivers of one robot, opened.

    Args:
        wires: What they are connected to.
        bus: Servo bus, connected.
        forces: Force stream, connected and running, or None to run without.
        armed: Whether torque may be switched on at all.
        recovery: Whether a servo that lost its torque may be brought back.
    """

    def __init__(
        self,
        wires: Wires,
        bus: ServoBus,
        forces: ForceStream | None,
        *,
        armed: bool,
        recovery: RecoverySettings,
    ) -> None:
        self.clock = wires.clock
        self.bus = bus
        self.calibrations: tuple[Calibration | None, ...] = (None,) * len(wires.unit.names)
        if forces is not None:
            self.calibrations = forces.calibrations
        self.unit_state = ""  # what changes the forces and is in no record, for the log
        self.warnings = bus.report.warnings
        if forces is not None and forces.unit_state is not None:
            self.unit_state = forces.unit_state.text
            self.warnings += forces.unit_state.warnings(wires.unit)
        self.armed = armed
        self._forces = forces
        self._truth = wires.truth
        self._closers = wires.closers
        self._poses: PoseListener | None = None
        self._imu: ImuListener | None = None
        self._torque = False
        self._link_lost = ""
        self._recovery = ServoRecovery(bus, policy_of(recovery))
        self._down: dict[int, Incident] = {}
        self._events: list[ServoEvent] = []

    @property
    def torque(self) -> bool:
        """Whether torque has been switched on and not confirmed off."""
        return self._torque

    @property
    def force_counters(self) -> StreamCounters | None:
        """What happened on the force stream, None without one."""
        return None if self._forces is None else self._forces.counters

    def read(self) -> Reading:
        """Read everything once. A lost link is a fault in the answer, not an exception."""
        faults: list[Fault] = []
        servos = self._read_servos(faults)
        records: tuple[ForceRecord, ...] = ()
        if self._forces is not None:
            records = self._forces.read()
            faults.extend(self._forces.take_faults())
        truth = self._truth.latest() if self._truth is not None else None
        poses: tuple[PoseRecord, ...] = ()
        if self._poses is not None:
            poses, bad = self._poses.read()
            faults.extend(bad)
        imu, bad = self.read_imu()
        faults.extend(bad)
        events, self._events = tuple(self._events), []
        return Reading(servos, records, truth, tuple(faults), poses, events, imu)

    def listen(self, poses: PoseListener) -> None:
        """Receive absolute poses too; the rig closes the listener."""
        self._poses = poses

    def listen_to_imu(self, imu: ImuListener) -> None:
        """Receive an IMU's readings too; the rig closes the listener."""
        self._imu = imu

    def read_imu(self) -> tuple[tuple[ImuRecord, ...], tuple[Fault, ...]]:
        """Return the readings of the IMU since the last read, and faults; nothing without one."""
        return self._imu.read() if self._imu is not None else ((), ())

    def _read_servos(self, faults: list[Fault]) -> ServoReadings:
        if not self._link_lost:
            try:
                readings = self.bus.read()
                for incident in self._recovery.look(readings):
                    self._down[incident.index] = incident
                    faults.append(self._note(FaultKind.SERVO_DOWN, incident, incident.words))
                return readings
            except ConnectionLost as error:
                self._link_lost = str(error)
        faults.append(Fault(FaultKind.LINK_LOST, "servo bus", self._link_lost))
        return silent_readings(self.clock.now_ns(), len(self.bus.settings.names))

    def _note(self, kind: FaultKind, incident: Incident, detail: str) -> Fault:
        """Keep an event for the controller's next tick; return the fault that goes with it."""
        self._events.append(ServoEvent(incident.index, kind))
        return Fault(kind, incident.leg, detail)

    def actuate(self, allowed: Allowed) -> tuple[Fault, ...]:
        """Send what the safety gate let through; nothing else reaches the servos.

        Returns:
            Faults met on the way, for the next tick.
        """
        command = allowed.command
        if not command.torque:
            if self._torque:
                self.cut_torque()
            return ()
        if not self.armed or self._link_lost:
            return ()
        try:
            if not self._torque:
                self._torque = True
                self.bus.torque_on()
            else:
                self.bus.write_goals(command)
            return tuple(self._bring_back(leg) for leg in allowed.recover)
        except ConnectionLost as error:
            self._link_lost = str(error)
        except BusError as error:
            return (Fault(FaultKind.SERVO_CORRUPT, "servo bus", str(error)),)
        return ()

    def _bring_back(self, leg: int) -> Fault:
        """Bring one servo back where it stands, and report the result. Blocks while it reboots."""
        incident = self._down[leg]
        result = self._recovery.recover(incident)
        if not result.recovered:
            off = "" if result.torque_off else "; its torque is not confirmed off"
            detail = f"{incident.words}, not brought back: {result.reason}{off}"
            return self._note(FaultKind.RECOVERY_FAILED, incident, detail)
        del self._down[leg]
        detail = f"{incident.words}, holds again at {result.goal_ticks} ticks"
        return self._note(FaultKind.SERVO_RECOVERED, incident, detail)

    def cut_torque(self) -> bool:
        """Switch all torque off.

        Returns:
            True if every servo confirmed it, or if torque was never switched on.
        """
        if not self._torque:
            return True
        confirmed = self.bus.torque_off()
        self._torque = not confirmed
        return confirmed

    def close(self) -> None:
        """Cut torque, stop the force stream and give everything back, whatever fails on the way."""
        try:
            self.cut_torque()
        finally:
            if self._forces is not None:
                self._forces.stop()
                self._forces.close()
            self.bus.close()
            if self._poses is not None:
                self._poses.close()
            if self._imu is not None:
                self._imu.close()
            for closer in self._closers:
                closer()


def policy_of(recovery: RecoverySettings) -> RecoveryPolicy:
    """Return the settings of a robot file for the driver, which keeps to them on its own account."""
    return RecoveryPolicy(recovery.most, recovery.window, recovery.causes, recovery.after_restart)
