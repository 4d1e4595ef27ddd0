"""Opening a robot at real ports, and connecting the drivers of any robot to its wires.

The virtual robots are in ``robot.virtual.open``: nothing of the simulator is loaded here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from drivers.ati.calibration import Calibration
from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.stream import ForceStream
from drivers.clock import Clock, MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.port import BusPort, ClockedPort
from drivers.settings import ForceSensorSettings
from drivers.wire.tap import WireTap
from robot.config.robot_file import RobotConfig
from robot.run.force_unit import console_opener, open_force_links
from robot.run.rig import Rig, TruthSource


@dataclass(frozen=True, slots=True, eq=False)
class Wires:
    """What the drivers of one robot are connected to.

    Attributes:
        clock: Clock of everything.
        port: Port of the servo bus, not yet open.
        unit: Force-torque unit.
        links: Opens both ways to it; None runs without one.
        reopen: Opens its console again beside the loop, untapped; None never does.
        truth: Source of ground truth, or None.
        closers: Called last when the rig closes.
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
    clock = MonotonicClock()
    port = BusPort(port_name, config.servo_bus.baud_rate, clock)
    wires = Wires(clock, port, config.force_sensor, None, truth=truth, closers=closers, tap=tap)
    if unit is not None:
        links = partial(open_force_links, unit, clock, tap)
        wires = replace(wires, unit=unit, links=links, reopen=console_opener(unit))
    return assemble(config, wires, armed=armed)


def assemble(config: RobotConfig, wires: Wires, *, armed: bool) -> Rig:
    """Connect the drivers of one robot to its wires.

    Args:
        config: Robot file.
        wires: The wires.
        armed: Whether torque may be switched on.
    """
    if wires.tap is not None:
        wires.tap.listen(wires.port)
    bus = ServoBus(wires.port, config.servo_bus, wires.clock)
    stream: ForceStream | None = None
    try:
        bus.connect()
        if armed:
            bus.configure()
        calibrations: tuple[Calibration | None, ...] = (None,) * len(wires.unit.names)
        if wires.links is not None:
            stream = ForceStream(*wires.links(), wires.unit, wires.clock, reopen=wires.reopen)
            stream.connect()
            calibrations = stream.calibrations
    except BaseException:
        if stream is not None:
            stream.stop()
            stream.close()
        bus.close()
        raise
    return Rig(
        clock=wires.clock,
        bus=bus,
        forces=stream,
        calibrations=calibrations,
        truth=wires.truth,
        armed=armed,
        closers=wires.closers,
        recovery=config.recovery,
    )
