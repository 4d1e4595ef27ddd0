"""One run as it is asked for, and the robot that it needs."""

from dataclasses import dataclass
from pathlib import Path

from drivers.wire.tap import WireTap
from model.errors import ConfigError
from robot.config.robot_file import DEFAULT_ROBOT_FILE, RobotConfig
from robot.run.force_unit import NO_UNIT, check_no_unit, unit_settings
from robot.run.hardware import open_real
from robot.run.rig import Rig

VIRTUAL = "virtual"


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveRequest:
    """The options of ``bigant drive``, under their names; ``robot.cli.drive`` says what each means."""

    robot: Path = DEFAULT_ROBOT_FILE
    calibration: Path | None = None
    gait: str = "tripod"
    cycles: float | None = None
    duration_s: float | None = None
    frequency_hz: float | None = None
    steer: float = 0.0
    hardware: str = VIRTUAL
    force_unit: str | None = None
    log: str | None = None
    record_bytes: bool = False
    pose_udp: int | None = None
    readonly: bool = False
    armed: bool = False
    teleop: bool = False
    deadman_s: float = 5.0
    rate_hz: int | None = None
    virtual_time: bool = False
    seed: int = 0
    scenario: Path | None = None

    @property
    def virtual(self) -> bool:
        """Whether the robot is a virtual one."""
        return self.hardware == VIRTUAL

    def check_hardware(self) -> None:
        """Refuse what the robot asked for cannot have.

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


def open_robot(config: RobotConfig, request: DriveRequest, tap: WireTap | None) -> Rig:
    """Open the robot of a run.

    Args:
        config: Robot file.
        request: The run, ``armed`` decided.
        tap: Listens in on all wires, from the first byte on; None for nobody.

    Raises:
        BigantError: It cannot be opened.
    """
    with_forces = request.force_unit != NO_UNIT
    if not request.virtual:
        unit = unit_settings(request.force_unit, config.force_sensor) if with_forces else None
        return open_real(config, request.hardware, unit, armed=request.armed, tap=tap)
    # here, so that the simulator is not in the process that drives a real robot
    from robot.virtual.open import VirtualSettings, open_in_memory, open_virtual
    from sim_hw.faults.scenario import load_scenario

    scenario = None
    if request.scenario is not None:
        scenario = load_scenario(request.scenario, [int(i) for i in config.servo_bus.ids])
    settings = VirtualSettings(request.seed, request.armed, with_forces, scenario, tap)
    return (open_in_memory if request.virtual_time else open_virtual)(config, settings)
