"""Opening a robot: virtual under a virtual clock, virtual in real time, or real ports.

The loop cannot tell them apart: each of these returns a ``Rig``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from drivers.ati.calibration import Calibration
from drivers.ati.links import DatagramLink, TcpTextLink, TextLink, UdpLink
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.setup import free_console
from drivers.ati.stream import ForceStream
from drivers.clock import Clock, MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import BusPort, ClockedPort
from drivers.wire.tap import TappedDatagrams, TappedText, WireTap
from model.values.readings import BodyTruth
from robot.config.robot_file import RobotConfig
from robot.console.progress import StatusLine
from robot.run.rig import Rig, TruthSource
from robot.virtual.file_twin import file_twin
from sim_hw.ati.memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.faults.scenario import Scenario
from sim_hw.host.server import DeviceProcess, VirtualSetup
from sim_hw.host.virtual_robot import VirtualRobot, build_virtual_robot, put_devices
from sim_hw.interfaces import HostedWorld
from sim_hw.twin.twin import Twin

MakeWorld = Callable[[FirmwareBank], HostedWorld]
LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, slots=True)
class _WorldTruth:
    """Truth straight from a world in this process."""

    robot: VirtualRobot
    clock: Clock

    def latest(self) -> BodyTruth | None:
        """Return the truth now, or what the cameras make of it; None on a bench without a body.

        The servos live on even when nobody can talk to them any more.
        """
        self.robot.servo_wire.poll(self.clock.now_ns())
        truth = self.robot.world.truth(self.clock.now_ns())
        cameras = self.robot.cameras
        return truth if cameras is None or truth is None else cameras.see(truth)


def open_in_memory(
    config: RobotConfig,
    *,
    seed: int,
    armed: bool,
    with_forces: bool,
    scenario: Scenario | None = None,
    tap: WireTap | None = None,
    bench: MakeWorld | None = None,
) -> Rig:
    """Open a virtual robot in memory under a virtual clock: no waiting, same bytes every time.

    Args:
        config: Robot file.
        seed: Seed of the virtual robot's noise.
        armed: Whether torque may be switched on.
        with_forces: Whether to use the force-torque unit.
        scenario: What goes wrong, None for sound devices.
        tap: Listens in on all wires, from the first byte on.
        bench: Makes the world that the devices stand in, None for the plant of the robot file.
    """
    rig, _ = open_twin(
        config,
        file_twin(config, seed) if bench is None else None,
        seed=seed,
        armed=armed,
        with_forces=with_forces,
        scenario=scenario,
        tap=tap,
        bench=bench,
        cameras=False,
    )
    return rig


def open_twin(
    config: RobotConfig,
    twin: Twin | None,
    *,
    seed: int,
    armed: bool,
    with_forces: bool,
    scenario: Scenario | None = None,
    tap: WireTap | None = None,
    bench: MakeWorld | None = None,
    cameras: bool = True,
) -> tuple[Rig, VirtualRobot]:
    """Open a twin of the robot in memory under a virtual clock; also return what is behind the devices.

    Args: as for ``open_in_memory``; ``twin``, what the robot really is, None for the nominal one; and
        ``cameras``, whether a twin's motion takes the place of the truth as its cameras see it.
    """
    clock = VirtualClock(start_ns=1_000_000_000)
    servo_bus, force_sensor = config.servo_bus, config.force_sensor
    if bench is None:
        robot = build_virtual_robot(
            config.parameters, servo_bus, force_sensor, seed, twin, scenario
        )
        robot = robot if cameras else replace(robot, cameras=None)
    else:
        firmware = FirmwareBank(len(servo_bus.ids))
        robot = put_devices(
            bench(firmware), firmware, servo_bus, force_sensor, seed, scenario=scenario
        )
    timer_s = scenario.adapter.latency_timer_s if scenario is not None else 0.0

    def links() -> tuple[DatagramLink, TextLink]:
        datagrams = MemoryDatagramLink(robot.wnet_wire, clock)
        console = MemoryTextLink(robot.wnet_wire, clock)
        if tap is None:
            return datagrams, console
        return TappedDatagrams(datagrams, tap, clock), TappedText(console, tap, clock)

    rig = assemble(
        config,
        clock=clock,
        port=MemoryPort(robot.servo_wire, clock, config.servo_bus.baud_rate, timer_s),
        reopen=None,  # nothing to wait for beside a virtual clock
        links=links if with_forces else None,
        settings=config.force_sensor,
        truth=_WorldTruth(robot, clock),
        armed=armed,
        closers=(),
        tap=tap,
    )
    return rig, robot


def start_virtual(
    config: RobotConfig, *, seed: int, scenario: Scenario | None = None
) -> tuple[DeviceProcess, ForceSensorSettings]:
    """Start virtual devices in a process of their own.

    Returns:
        The process, to be closed, and where its force-torque unit is.
    """
    setup = VirtualSetup(
        config.parameters,
        config.servo_bus,
        config.force_sensor,
        seed,
        scenario=scenario,
        twin=file_twin(config, seed),
    )
    with StatusLine() as line:
        devices = DeviceProcess(setup, lambda: line.say("starting the virtual robot"))
    settings = replace(
        config.force_sensor,
        address=LOOPBACK,
        udp_port=devices.addresses.udp_port,
        console_port=devices.addresses.console_port,
        local_port=0,
    )
    return devices, settings


def open_force_links(
    unit: ForceSensorSettings, clock: Clock, tap: WireTap | None = None
) -> tuple[DatagramLink, TextLink]:
    """Open both ways to a force-torque unit; its console is freed first.

    Raises:
        ForceStreamError: Nobody answers.
    """
    udp = UdpLink(unit.address, unit.udp_port, unit.local_port, clock)
    datagrams = udp if tap is None else TappedDatagrams(udp, tap, clock)
    free_console(datagrams, clock)
    try:
        console = TcpTextLink(unit.address, unit.console_port)
        return datagrams, console if tap is None else TappedText(console, tap, clock)
    except BaseException:
        datagrams.close()
        raise


def open_virtual(
    config: RobotConfig,
    *,
    seed: int,
    armed: bool,
    with_forces: bool,
    scenario: Scenario | None = None,
    tap: WireTap | None = None,
) -> Rig:
    """Open a virtual robot in a process of its own: pseudo-terminal, sockets, real time.

    Args: as for ``open_in_memory``.
    """
    devices, settings = start_virtual(config, seed=seed, scenario=scenario)
    try:
        return _open_ports(
            config,
            devices.addresses.servo_port,
            settings if with_forces else None,
            truth=devices.truth,
            armed=armed,
            closers=(devices.close,),
            tap=tap,
        )
    except BaseException:
        devices.close()
        raise


def open_real(
    config: RobotConfig,
    port_name: str,
    force_sensor: ForceSensorSettings | None,
    *,
    armed: bool,
    tap: WireTap | None = None,
) -> Rig:
    """Open real ports. Nothing moves unless ``armed``.

    Args:
        config: Robot file.
        port_name: Serial port of the servo bus.
        force_sensor: Force-torque unit, or None to run without.
        armed: Whether torque may be switched on.
        tap: Listens in on all wires, from the first byte on.
    """
    return _open_ports(
        config, port_name, force_sensor, truth=None, armed=armed, closers=(), tap=tap
    )


def _open_ports(
    config: RobotConfig,
    port_name: str,
    force_sensor: ForceSensorSettings | None,
    *,
    truth: TruthSource | None,
    armed: bool,
    closers: tuple[Callable[[], None], ...],
    tap: WireTap | None,
) -> Rig:
    clock = MonotonicClock()
    links = reopen = None
    if force_sensor is not None:
        unit = force_sensor

        def links() -> tuple[DatagramLink, TextLink]:
            return open_force_links(unit, clock, tap)

        def reopen() -> TextLink:
            return TcpTextLink(unit.address, unit.console_port)

    return assemble(
        config,
        clock=clock,
        port=BusPort(port_name, config.servo_bus.baud_rate, clock),
        links=links,
        reopen=reopen,
        settings=force_sensor if force_sensor is not None else config.force_sensor,
        truth=truth,
        armed=armed,
        closers=closers,
        tap=tap,
    )


def assemble(
    config: RobotConfig,
    *,
    clock: Clock,
    port: ClockedPort,
    links: Callable[[], tuple[DatagramLink, TextLink]] | None,
    reopen: Callable[[], TextLink] | None,
    settings: ForceSensorSettings,
    truth: TruthSource | None,
    armed: bool,
    closers: tuple[Callable[[], None], ...],
    tap: WireTap | None = None,
) -> Rig:
    """Connect the drivers of one robot to its wires.

    Args:
        config: Robot file.
        clock: Clock of everything.
        port: Port of the servo bus, not yet open.
        links: Opens the ways to the force-torque unit; None runs without one.
        reopen: Opens its console again beside the loop, untapped; None never does.
        settings: Force-torque unit.
        truth: Source of ground truth, or None.
        armed: Whether torque may be switched on.
        closers: Called last when the rig closes.
        tap: Listens to the servo port; whoever opens ``links`` taps those.
    """
    if tap is not None:
        tap.listen(port)
    bus = ServoBus(port, config.servo_bus, clock)
    stream: ForceStream | None = None
    try:
        bus.connect()
        if armed:
            bus.configure()
        calibrations: tuple[Calibration | None, ...] = (None,) * len(settings.names)
        if links is not None:
            stream = ForceStream(*links(), settings, clock, reopen=reopen)
            stream.connect()
            calibrations = stream.calibrations
    except BaseException:
        if stream is not None:
            stream.stop()
            stream.close()
        bus.close()
        raise
    return Rig(
        clock=clock,
        bus=bus,
        forces=stream,
        calibrations=calibrations,
        truth=truth,
        armed=armed,
        closers=closers,
        recovery=config.recovery,
    )
