"""The device process: virtual servos on a pseudo-terminal and a virtual WNet on loopback sockets.

It has a process of its own so that the plant's arithmetic never competes with the control loop for
Python's interpreter lock, and so that a control program can be killed while its robot goes on
existing, which is the case the servos' watchdog is for.
"""

import contextlib
import os
import select
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import TemporaryDirectory

from drivers.ati.settings import ForceSensorSettings
from drivers.clock import Clock, MonotonicClock
from drivers.dynamixel.settings import ServoBusSettings
from model.errors import BusError
from model.values.parameters import RobotParameters
from model.values.readings import BodyTruth
from sim_hw.ati.sockets import WnetSockets
from sim_hw.dynamixel.pty import PtyServoBus
from sim_hw.faults.kinds import Unplug
from sim_hw.faults.scenario import Scenario
from sim_hw.host.imu_lines import ImuSetup, PtyImu
from sim_hw.host.virtual_robot import VirtualRobot, build_virtual_robot
from sim_hw.interfaces import Served
from sim_hw.twin.twin import Twin

TRUTH_PERIOD_NS = 10_000_000
# The world is brought up to date at least so often, so that it never has much to catch up on.
IDLE_PERIOD_NS = 2_000_000
# A host that stood still longer than this lets the virtual robot stand still with it: one that is too
# slow for the plant has a slow robot then, whose servos still answer in time.
LARGEST_CATCH_UP_NS = 10_000_000
START_LIMIT_S = 120.0  # a busy machine that has to compile the plant first
START_LOOK_S = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class VirtualSetup:
    """What the device process is to be.

    Attributes:
        robot: Nominal parameters.
        servo_bus: Ids, mounting and baud rate of the servos.
        force_sensor: Transducers and their mounting.
        seed: Seed of all noise.
        absent_ids: Servos that do not answer.
        with_wnet: False leaves the force-torque unit out.
        scenario: What goes wrong, None for sound devices.
        twin: What robot and sensors really are, None for the nominal ones.
        imu: The IMU on its body, None for none.
    """

    robot: RobotParameters
    servo_bus: ServoBusSettings
    force_sensor: ForceSensorSettings
    seed: int
    absent_ids: tuple[int, ...] = ()
    with_wnet: bool = True
    scenario: Scenario | None = None
    twin: Twin | None = None
    imu: ImuSetup | None = None


@dataclass(frozen=True, slots=True)
class Addresses:
    """Where the virtual devices are to be found.

    Attributes:
        servo_port: Device name of the pseudo-terminal.
        udp_port: UDP port of the force-torque unit on loopback, 0 if it is absent.
        console_port: Its console port, 0 if it is absent.
        imu_port: Device name of the IMU's pseudo-terminal, empty if it is absent.
    """

    servo_port: str
    udp_port: int
    console_port: int
    imu_port: str = ""


def serve(
    robot: VirtualRobot,
    devices: list[Served],
    clock: Clock,
    truth: Connection | None,
    control: Connection | None,
) -> None:
    """Serve devices until the control connection says stop or closes.

    Args:
        robot: The virtual robot behind the devices.
        devices: The devices to serve.
        clock: Clock of the world.
        truth: Where ground truth goes, if anywhere; what its receiver does not take is lost.
        control: Any message or its end stops the process; None serves for ever.
    """
    truth_due_ns = clock.now_ns()
    while True:
        now_ns = clock.now_ns()
        robot.world.stand_still_until(now_ns - LARGEST_CATCH_UP_NS)
        robot.world.advance_to(now_ns)
        for device in devices:
            device.service(now_ns)
        if truth is not None and now_ns >= truth_due_ns:
            where = robot.world.truth(now_ns)
            if where is not None and select.select([], [truth], [], 0)[1]:
                with contextlib.suppress(OSError):
                    truth.send(where)
            truth_due_ns = now_ns - now_ns % TRUTH_PERIOD_NS + TRUTH_PERIOD_NS
        due = [t for device in devices if (t := device.next_due_ns()) is not None]
        next_ns = min([*due, now_ns + IDLE_PERIOD_NS])
        watched = [fd for device in devices for fd in device.filenos()]
        if control is not None:
            watched.append(control.fileno())
        ready, _, _ = select.select(watched, [], [], max(0.0, (next_ns - clock.now_ns()) * 1e-9))
        if control is not None and control.fileno() in ready:
            return


def _device_process(setup: VirtualSetup, control: Connection, truth_end: Connection) -> None:
    # Ctrl-C, a closed terminal and `timeout` reach the whole process group, but are for the controller to
    # act on: the robot has to be there until it has stopped.
    os.setpgid(0, 0)
    robot = build_virtual_robot(
        setup.robot, setup.servo_bus, setup.force_sensor, setup.seed, setup.twin, setup.scenario,
        setup.imu,
    )  # fmt: skip
    for servo_id in setup.absent_ids:
        robot.servos.silence(servo_id)
    clock = MonotonicClock()
    with ExitStack() as stack:
        pty = open_servo_pty(robot, setup.scenario, stack)
        devices: list[Served] = [pty]
        udp_port = console_port = 0
        if setup.with_wnet:
            sockets = WnetSockets(robot.wnet_wire)
            stack.callback(sockets.close)
            devices.append(sockets)
            udp_port, console_port = sockets.udp_port, sockets.console_port
        imu = open_imu_pty(robot, clock, stack)
        if imu is not None:
            devices.append(imu)
        imu_port = imu.device_name if imu is not None else ""
        control.send(Addresses(pty.device_name, udp_port, console_port, imu_port))
        serve(robot, devices, clock, truth_end, control)


def open_servo_pty(
    robot: VirtualRobot,
    scenario: Scenario | None,
    stack: ExitStack,
    notice: Callable[[str], None] = lambda _: None,
) -> PtyServoBus:
    """Open the servo bus of a virtual robot on a pseudo-terminal, closed with the stack.

    ``notice`` is told when it answers late.

    Where the scenario pulls the cable it gets a name that stays the same when it is plugged in again.
    """
    link = None
    if scenario is not None and any(isinstance(fault, Unplug) for fault in scenario.faults):
        link = Path(stack.enter_context(TemporaryDirectory(prefix="bigant-"))) / "servo_bus"
    pty = PtyServoBus(robot.servo_wire, link, notice)
    stack.callback(pty.close)
    return pty


def open_imu_pty(robot: VirtualRobot, clock: Clock, stack: ExitStack) -> PtyImu | None:
    """Open the IMU of a virtual robot on a pseudo-terminal, closed with the stack; None without one."""
    if robot.imu is None:
        return None
    robot.imu.offset_ns = time.time_ns() - clock.now_ns()
    imu = PtyImu(robot.imu)
    stack.callback(imu.close)
    return imu


class TruthReceiver:
    """Keeps the newest ground truth that the device process has sent.

    It comes as a motion-capture system's would on the real robot: on a path of its own, never through the
    robot's devices.
    """

    def __init__(self, end: Connection) -> None:
        self._end = end
        self._latest: BodyTruth | None = None

    def latest(self) -> BodyTruth | None:
        """Return the newest truth, None if none ever came."""
        with contextlib.suppress(EOFError, OSError):
            while self._end.poll():
                self._latest = self._end.recv()
        return self._latest

    def close(self) -> None:
        """Close its end."""
        self._end.close()


class DeviceProcess:
    """A running device process. Use it as a context manager.

    Args:
        setup: What it is to be.
        waiting: Called now and then until it is ready; its very first start compiles the plant.
    """

    def __init__(self, setup: VirtualSetup, waiting: Callable[[], None] = lambda: None) -> None:
        context = get_context("spawn")
        self._control, far = context.Pipe()
        near_truth, far_truth = context.Pipe(duplex=False)
        self._process: BaseProcess = context.Process(
            target=_device_process, args=(setup, far, far_truth), daemon=True
        )
        self._process.start()
        far.close()
        far_truth.close()
        self.truth = TruthReceiver(near_truth)
        self.addresses = self._await_addresses(waiting)

    def _await_addresses(self, waiting: Callable[[], None]) -> Addresses:
        with contextlib.suppress(EOFError):
            for _ in range(round(START_LIMIT_S / START_LOOK_S)):
                if self._control.poll(START_LOOK_S):
                    addresses: Addresses = self._control.recv()
                    return addresses
                waiting()
        self.close()
        raise BusError(
            "the virtual hardware did not start; run with --virtual-time to see the error itself"
        )

    def close(self) -> None:
        """Stop the process and wait for it."""
        self._control.close()
        self._process.join(5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self.truth.close()
