"""Opening a robot at real ports, and connecting the drivers of any robot to its wires.

The virtual robots are in ``robot.virtual.open``: nothing of the simulator is loaded here.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import BusPort
from drivers.wire.tap import WireTap
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
