"""Opening a virtual robot: in memory under a virtual clock, or in real time in a process of its own.

For the loop it is the same as a real one (``robot.run.hardware``): each of these returns a ``Rig``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.settings import ForceSensorSettings
from drivers.clock import Clock
from drivers.lines.imu import ImuListener
from drivers.wire.tap import TappedDatagrams, TappedText, WireTap
from model.values.arrays import readonly
from model.values.readings import BodyTruth
from robot.config.robot_file import RobotConfig
from robot.console.progress import StatusLine
from robot.run.hardware import assemble, open_imu, open_real
from robot.run.rig import Rig, Wires
from robot.virtual.file_twin import file_twin
from sim_hw.assumed import ImuAssumed
from sim_hw.ati.memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.faults.scenario import Scenario
from sim_hw.host.imu_lines import ImuSetup, MemoryImuLines
from sim_hw.host.server import DeviceProcess, VirtualSetup
from sim_hw.host.virtual_robot import VirtualRobot, build_virtual_robot, put_devices
from sim_hw.host.world import World
from sim_hw.interfaces import HostedWorld
from sim_hw.twin.twin import Twin

MakeWorld = Callable[[FirmwareBank], HostedWorld]
LOOPBACK = "127.0.0.1"
START_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class VirtualSettings:
    """How a virtual robot is opened.

    Attributes:
        seed: Seed of its noise.
        armed: Whether torque may be switched on.
        with_forces: Whether to use the force-torque unit, if the robot has force sensors.
        scenario: What goes wrong, None for sound devices.
        tap: Listens in on all wires, from the first byte on; None for nobody.
        there: The robot that is really there; None for the one that the robot file says.
        imu: The IMU on its body; None for that of the scenario, or of a robot file that has one.
        with_imu: Whether there is an IMU at all.
    """

    seed: int = 0
    armed: bool = True
    with_forces: bool = True
    scenario: Scenario | None = None
    tap: WireTap | None = None
    there: RobotConfig | None = None
    imu: ImuAssumed | None = None
    with_imu: bool = True


USUAL = VirtualSettings()


@dataclass(frozen=True, slots=True)
class _WorldTruth:
    """Truth straight from a world in this process."""

    robot: VirtualRobot
    clock: Clock

    def latest(self) -> BodyTruth | None:
        """Return the truth now, or what the cameras measure of it; None on a bench without a body.

        The servos live on even when nobody can talk to them any more.
        """
        self.robot.servo_wire.poll(self.clock.now_ns())
        world, cameras = self.robot.world, self.robot.cameras
        truth = world.truth(self.clock.now_ns())
        if cameras is None or truth is None:
            return truth
        assert isinstance(world, World), "a twin is no bench"
        return cameras.see(replace(truth, foot_position_W=readonly(world.places()[2])))


def open_in_memory(
    config: RobotConfig, settings: VirtualSettings = USUAL, *, bench: MakeWorld | None = None
) -> Rig:
    """Open a virtual robot in memory under a virtual clock: no waiting, same bytes every time.

    Args:
        config: Robot file.
        settings: How.
        bench: Makes the world that the devices stand in, None for the plant of the robot file.
    """
    there = settings.there or config
    if bench is None:
        return open_twin(config, file_twin(there, settings.seed), settings, cameras=False)[0]
    firmware = FirmwareBank(len(there.servo_bus.ids))
    robot = put_devices(
        bench(firmware),
        firmware,
        there.servo_bus,
        there.force_sensor,
        settings.seed,
        scenario=settings.scenario,
    )
    return _in_memory(config, robot, settings)


def open_twin(
    config: RobotConfig,
    twin: Twin | None,
    settings: VirtualSettings = USUAL,
    *,
    cameras: bool = True,
) -> tuple[Rig, VirtualRobot]:
    """Open a twin of the robot in memory under a virtual clock; also return what is behind the devices.

    Args:
        config: Robot file.
        twin: What the robot really is, None for the nominal one.
        settings: How.
        cameras: Whether a twin's motion takes the place of the truth as its cameras see it.
    """
    there = settings.there or config
    robot = build_virtual_robot(
        there.parameters,
        there.servo_bus,
        there.force_sensor,
        settings.seed,
        twin,
        settings.scenario,
        imu_setup(there, settings),
    )
    robot = robot if cameras else replace(robot, cameras=None)
    return _in_memory(config, robot, settings), robot


def _in_memory(config: RobotConfig, robot: VirtualRobot, settings: VirtualSettings) -> Rig:
    clock = new_clock()
    rig = assemble(config, memory_wires(config, robot, settings, clock), armed=settings.armed)
    if robot.imu is not None:
        lines = MemoryImuLines(robot.imu, robot.world, clock)
        # its clock is ours: no time of day, so that the same run gives the same
        rig.listen_to_imu(ImuListener(lines, clock, clock.now_ns(), config.imu.stale_after))
    return rig


def new_clock() -> VirtualClock:
    """Return a virtual clock as every robot in memory begins with."""
    return VirtualClock(start_ns=START_NS)


def memory_wires(
    config: RobotConfig, robot: VirtualRobot, settings: VirtualSettings, clock: VirtualClock
) -> Wires:
    """Return what the drivers of a robot in memory are connected to.

    Args:
        config: Robot file that the drivers use.
        robot: The virtual robot.
        settings: How it is opened.
        clock: The clock that all of it lives by.
    """
    scenario, tap = settings.scenario, settings.tap
    timer_s = scenario.adapter.latency_timer_s if scenario is not None else 0.0

    def links() -> tuple[DatagramLink, TextLink]:
        datagrams = MemoryDatagramLink(robot.wnet_wire, clock)
        console = MemoryTextLink(robot.wnet_wire, clock)
        if tap is None:
            return datagrams, console
        return TappedDatagrams(datagrams, tap, clock), TappedText(console, tap, clock)

    return Wires(
        clock,
        MemoryPort(robot.servo_wire, clock, config.servo_bus.baud_rate, timer_s),
        config.force_sensor,
        links=links if settings.with_forces and config.force_sensor.any else None,
        truth=_WorldTruth(robot, clock),
        tap=tap,
    )


def start_virtual(
    config: RobotConfig, settings: VirtualSettings = USUAL
) -> tuple[DeviceProcess, ForceSensorSettings]:
    """Start virtual devices in a process of their own.

    Returns:
        The process, to be closed, and where its force-torque unit is.
    """
    there = settings.there or config
    setup = VirtualSetup(
        there.parameters,
        there.servo_bus,
        there.force_sensor,
        settings.seed,
        with_wnet=there.force_sensor.any,
        scenario=settings.scenario,
        twin=file_twin(there, settings.seed),
        imu=imu_setup(there, settings),
    )
    with StatusLine() as line:
        devices = DeviceProcess(setup, lambda: line.say("starting the virtual robot"))
    unit = replace(
        config.force_sensor,
        address=LOOPBACK,
        udp_port=devices.addresses.udp_port,
        console_port=devices.addresses.console_port,
        local_port=0,
    )
    return devices, unit


def open_virtual(config: RobotConfig, settings: VirtualSettings) -> Rig:
    """Open a virtual robot in a process of its own: pseudo-terminal, sockets, real time."""
    devices, unit = start_virtual(config, settings)
    try:
        rig = open_real(
            config,
            devices.addresses.servo_port,
            unit if settings.with_forces and config.force_sensor.any else None,
            armed=settings.armed,
            tap=settings.tap,
            truth=devices.truth,
            closers=(devices.close,),
        )
    except BaseException:
        devices.close()
        raise
    if devices.addresses.imu_port:
        there = replace(config.imu, udp_port=0, port=devices.addresses.imu_port)
        rig.listen_to_imu(open_imu(there, rig.clock))
    return rig


def imu_setup(there: RobotConfig, settings: VirtualSettings) -> ImuSetup | None:
    """Return the IMU of the robot that is there; None for none."""
    assumed = settings.imu
    if assumed is None and settings.scenario is not None:
        assumed = settings.scenario.imu
    if assumed is None and there.imu.any:
        assumed = ImuAssumed()
    if assumed is None or not settings.with_imu:
        return None
    return ImuSetup(assumed, settings.seed, there.imu.to_body)
