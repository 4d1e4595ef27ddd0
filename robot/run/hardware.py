"""Opening a robot at real ports, and connecting the drivers of any robot to its wires.

The virtual robots are in ``robot.virtual.open``: nothing of the simulator is loaded here.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import Clock, MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import BusPort
from drivers.lines.imu import ImuListener
from drivers.lines.sources import LineSource, SerialLines, UdpLines
from drivers.wire.tap import WireTap
from model.errors import ConfigError
from robot.config.imu import ImuConfig
from robot.config.robot_file import RobotConfig
from robot.run.force_unit import console_opener, open_force_links
from robot.run.rig import Rig, TruthSource, Wires


def open_real(
    config: RobotConfig,
    port_name: str,
    unit: ForceSensorSettings | None,
    *,
    armed: bool,
    tap: WireTap | None = None,
    truth: TruthSource | None = None,
    closers: tuple[Callable[[], None], ...] = (),
) -> Rig:
    """Open ports of this computer. Nothing moves unless ``armed``.

    Args:
        config: Robot file.
        port_name: Serial port of the servo bus.
        unit: Force-torque unit, or None to run without.
        armed: Whether torque may be switched on.
        tap: Listens in on all wires, from the first byte on.
        truth: Source of ground truth, or None.
        closers: Called last when the rig closes.
    """
    wires = real_wires(config, port_name, unit, tap)
    return assemble(config, replace(wires, truth=truth, closers=closers), armed=armed)


def real_wires(
    config: RobotConfig, port_name: str, unit: ForceSensorSettings | None, tap: WireTap | None
) -> Wires:
    """Return ports of this computer, not yet open; arguments as for ``open_real``."""
    clock = MonotonicClock()
    port = BusPort(port_name, config.servo_bus.baud_rate, clock)
    wires = Wires(clock, port, config.force_sensor, None, tap=tap)
    if unit is None:
        return wires
    links = partial(open_force_links, unit, clock, tap)
    return replace(wires, unit=unit, links=links, reopen=console_opener(unit))


def open_imu(config: ImuConfig, clock: Clock, option: str = "imu") -> ImuListener:
    """Open the IMU of a robot file on this computer.

    Args:
        config: Where it is; one of its two places is set.
        clock: The loop's clock.
        option: What asked for it, for an error.

    Raises:
        ConfigError: The port cannot be had.
    """
    source: LineSource
    if config.udp_port:
        source = UdpLines(config.udp_port, option)
    else:
        source = SerialLines(config.port, config.baud_rate, option, clock)
    return ImuListener(source, clock, time.time_ns(), config.stale_after)


def imu_place(text: str, config: ImuConfig) -> ImuConfig:
    """Return an IMU with another place: a number is a UDP port, anything else a serial port.

    Raises:
        ConfigError: The number is no port.
    """
    if not text.isdecimal():
        return replace(config, udp_port=0, port=text)
    if not 0 < int(text) < 65536:
        raise ConfigError("--imu", f"a UDP port is a number from 1 to 65535, not {text}")
    return replace(config, udp_port=int(text), port="")


def assemble(config: RobotConfig, wires: Wires, *, armed: bool) -> Rig:
    """Connect the drivers of one robot to its wires.

    Args:
        config: Robot file.
        wires: The wires.
        armed: Whether torque may be switched on.
    """
    if wires.tap is not None:
        wires.tap.listen(wires.port)
    bus = ServoBus(wires.port, config.servo_bus)
    bus.prepare()
    stream: ForceStream | None = None
    try:
        bus.connect()
        if armed:
            bus.configure()
        if wires.links is not None:
            stream = ForceStream(*wires.links(), wires.unit, wires.clock, reopen=wires.reopen)
            stream.connect()
    except BaseException:
        if stream is not None:
            stream.stop()
            stream.close()
        bus.close()
        raise
    return Rig(wires, bus, stream, armed=armed, recovery=config.recovery)
