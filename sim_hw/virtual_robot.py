"""One virtual robot: a plant, the servos' firmware, and the two devices in front of them."""

from dataclasses import dataclass

from drivers.settings import ForceSensorSettings, ServoBusSettings
from model.params import RobotParameters
from sim_hw.ati import VirtualWnet
from sim_hw.plant import Plant
from sim_hw.plant_parameters import PlantParameters
from sim_hw.servo_firmware import FirmwareBank
from sim_hw.servos import VirtualServoBus
from sim_hw.world import World


@dataclass(frozen=True, slots=True)
class VirtualRobot:
    """The virtual robot's parts.

    Attributes:
        world: Plant and firmware, running together in steps.
        servos: Virtual servo bus.
        wnet: Virtual wireless force-torque unit.
    """

    world: World
    servos: VirtualServoBus
    wnet: VirtualWnet


def build_virtual_robot(
    robot: RobotParameters,
    servo_bus: ServoBusSettings,
    force_sensor: ForceSensorSettings,
    seed: int,
    plant: PlantParameters | None = None,
) -> VirtualRobot:
    """Build a virtual robot for a robot file.

    Args:
        robot: Nominal parameters; geometry is copied from them when ``plant`` is not given.
        servo_bus: Ids, mounting and baud rate of the servos.
        force_sensor: Transducers and their mounting.
        seed: Seed of all noise.
        plant: The plant's own parameters.
    """
    parameters = plant if plant is not None else PlantParameters.nominal(robot)
    firmware = FirmwareBank(robot.legs.count)
    world = World(
        Plant(parameters, seed),
        firmware,
        signs=servo_bus.signs,
        zeros=servo_bus.zeros,
        sensor_offset_m=force_sensor.offset_m,
        sensor_yaw_rad=force_sensor.yaw_rad,
    )
    ids = tuple(int(i) for i in servo_bus.ids)
    return VirtualRobot(
        world=world,
        servos=VirtualServoBus(world, firmware, ids, baud_rate=servo_bus.baud_rate),
        wnet=VirtualWnet(world, tuple(int(t) for t in force_sensor.transducers), seed=seed),
    )
