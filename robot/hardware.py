"""Opening a robot: virtual under a virtual clock, virtual in real time, or real ports.

The loop cannot tell them apart: each of these returns a ``Rig``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from drivers.ati_calibration import Calibration
from drivers.ati_links import DatagramLink, TcpTextLink, TextLink, UdpLink
from drivers.ati_stream import ForceStream, free_console
from drivers.clock import Clock, MonotonicClock
from drivers.servo_bus import ServoBus
from drivers.servo_port import BusPort, ClockedPort
from drivers.settings import ForceSensorSettings
from model.signals import BodyTruth
from robot.config import RobotConfig
from robot.rig import Rig, TruthSource
from sim_hw.ati_memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.clock import VirtualClock
from sim_hw.port import MemoryPort
from sim_hw.server import DeviceProcess, VirtualSetup
from sim_hw.twin import Twin
from sim_hw.virtual_robot import VirtualRobot, build_virtual_robot

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, slots=True)
class _WorldTruth:
    """Truth straight from a world in this process."""

    robot: VirtualRobot
    clock: Clock

    def latest(self) -> BodyTruth:
        """Return the truth now, or what the cameras make of it."""
        truth = self.robot.world.truth(self.clock.now_ns())
        return truth if self.robot.cameras is None else self.robot.cameras.see(truth)


def open_in_memory(config: RobotConfig, *, seed: int, armed: bool, with_forces: bool) -> Rig:
    """Open a virtual robot in memory under a virtual clock: no waiting, same bytes every time."""
    return open_twin(config, None, seed=seed, armed=armed, with_forces=with_forces)[0]


def open_twin(
    config: RobotConfig, twin: Twin | None, *, seed: int, armed: bool, with_forces: bool
) -> tuple[Rig, VirtualRobot]:
    """Open a twin of the robot in memory under a virtual clock; also return what is behind the devices."""
    clock = VirtualClock(start_ns=1_000_000_000)
    robot = build_virtual_robot(
        config.parameters, config.servo_bus, config.force_sensor, seed, twin
    )
    rig = _assemble(
        config,
        clock=clock,
        port=MemoryPort(robot.servos, clock, config.servo_bus.baud_rate),
        links=(
            (lambda: (MemoryDatagramLink(robot.wnet, clock), MemoryTextLink(robot.wnet, clock)))
            if with_forces
            else None
        ),
        settings=config.force_sensor,
        truth=_WorldTruth(robot, clock),
        armed=armed,
        closers=(),
    )
    return rig, robot


def open_virtual(config: RobotConfig, *, seed: int, armed: bool, with_forces: bool) -> Rig:
    """Open a virtual robot in a process of its own: pseudo-terminal, sockets, real time."""
    devices = DeviceProcess(
        VirtualSetup(config.parameters, config.servo_bus, config.force_sensor, seed)
    )
    settings = replace(
        config.force_sensor,
        address=LOOPBACK,
        udp_port=devices.addresses.udp_port,
        console_port=devices.addresses.console_port,
        local_port=0,
    )
    try:
        return _open_ports(
            config,
            devices.addresses.servo_port,
            settings if with_forces else None,
            truth=devices.truth,
            armed=armed,
            closers=(devices.close,),
        )
    except BaseException:
        devices.close()
        raise


def open_real(
    config: RobotConfig, port_name: str, force_sensor: ForceSensorSettings | None, *, armed: bool
) -> Rig:
    """Open real ports. Nothing moves unless ``armed``.

    Args:
        config: Robot file.
        port_name: Serial port of the servo bus.
        force_sensor: Force-torque unit, or None to run without.
        armed: Whether torque may be switched on.
    """
    return _open_ports(config, port_name, force_sensor, truth=None, armed=armed, closers=())


def _open_ports(
    config: RobotConfig,
    port_name: str,
    force_sensor: ForceSensorSettings | None,
    *,
    truth: TruthSource | None,
    armed: bool,
    closers: tuple[Callable[[], None], ...],
) -> Rig:
    clock = MonotonicClock()
    links = None
    if force_sensor is not None:
        unit = force_sensor

        def links() -> tuple[DatagramLink, TextLink]:
            datagrams = UdpLink(unit.address, unit.udp_port, unit.local_port, clock)
            free_console(datagrams, clock)
            try:
                return datagrams, TcpTextLink(unit.address, unit.console_port)
            except BaseException:
                datagrams.close()
                raise

    return _assemble(
        config,
        clock=clock,
        port=BusPort(port_name, config.servo_bus.baud_rate, clock),
        links=links,
        settings=force_sensor if force_sensor is not None else config.force_sensor,
        truth=truth,
        armed=armed,
        closers=closers,
    )


def _assemble(
    config: RobotConfig,
    *,
    clock: Clock,
    port: ClockedPort,
    links: Callable[[], tuple[DatagramLink, TextLink]] | None,
    settings: ForceSensorSettings,
    truth: TruthSource | None,
    armed: bool,
    closers: tuple[Callable[[], None], ...],
) -> Rig:
    bus = ServoBus(port, config.servo_bus, clock)
    stream: ForceStream | None = None
    try:
        bus.connect()
        if armed:
            bus.configure()
        calibrations: tuple[Calibration | None, ...] = (None,) * len(settings.names)
        if links is not None:
            stream = ForceStream(*links(), settings, clock)
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
    )
