"""Which robot is driven, and how it is reached: at real ports, or virtual."""

import time
from dataclasses import dataclass
from pathlib import Path

from drivers.pose_udp import PoseListener
from drivers.wire.tap import WireTap
from model.errors import ConfigError
from robot.config.robot_file import RobotConfig
from robot.run.force_unit import NO_UNIT, check_no_unit, unit_settings
from robot.run.hardware import open_real
from robot.run.rig import Rig

VIRTUAL = "virtual"


@dataclass(frozen=True, slots=True)
class RobotAccess:
    """Which robot, and how it is reached.

    Attributes:
        hardware: ``virtual``, or the serial port of the servo bus.
        armed: Whether torque may be switched on.
        force_unit: Address of the force-torque unit, ``none`` for none, None for the robot file's.
        virtual_time: Whether virtual hardware lives in memory under a virtual clock.
        seed: Seed of virtual noise.
        scenario: File of the faults of virtual hardware, None for none.
        pose_udp: UDP port for absolute poses, None for the robot file's.
        record_bytes: Whether the bytes of both devices go into the log.
    """

    hardware: str
    armed: bool
    force_unit: str | None = None
    virtual_time: bool = False
    seed: int = 0
    scenario: Path | None = None
    pose_udp: int | None = None
    record_bytes: bool = False

    @property
    def virtual(self) -> bool:
        """Whether the robot is a virtual one."""
        return self.hardware == VIRTUAL

    def check(self) -> None:
        """Refuse what does not go together.

        Raises:
            ConfigError: It makes no sense.
        """
        if self.virtual_time and not self.virtual:
            raise ConfigError(
                "--virtual-time", "needs --hardware virtual; real servos live in real time"
            )
        if self.virtual:
            check_no_unit(self.force_unit)
        if self.scenario is not None and not self.virtual:
            raise ConfigError(
                "--scenario", "needs --hardware virtual; faults are put on virtual devices only"
            )


def open_robot(config: RobotConfig, access: RobotAccess, tap: WireTap | None) -> Rig:
    """Open the robot, with a listener for absolute poses where they are wanted.

    Args:
        config: Robot file.
        access: Which robot, and how.
        tap: Listens in on all wires, from the first byte on; None for nobody.

    Raises:
        BigantError: It cannot be opened.
    """
    rig = _open(config, access, tap)
    port = access.pose_udp or config.estimator.pose_port
    if port:
        try:
            rig.listen(PoseListener(port, rig.clock, time.time_ns()))
        except BaseException:
            rig.close()
            raise
    return rig


def _open(config: RobotConfig, access: RobotAccess, tap: WireTap | None) -> Rig:
    with_forces = access.force_unit != NO_UNIT
    if not access.virtual:
        unit = unit_settings(access.force_unit, config.force_sensor) if with_forces else None
        return open_real(config, access.hardware, unit, armed=access.armed, tap=tap)
    # here, so that the simulator is not in the process that drives a real robot
    from robot.virtual.open import VirtualSettings, open_in_memory, open_virtual
    from sim_hw.faults.scenario import load_scenario

    scenario = None
    if access.scenario is not None:
        scenario = load_scenario(access.scenario, [int(i) for i in config.servo_bus.ids])
    settings = VirtualSettings(access.seed, access.armed, with_forces, scenario, tap)
    return (open_in_memory if access.virtual_time else open_virtual)(config, settings)
