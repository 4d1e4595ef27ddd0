"""One virtual robot: a plant, the servos' firmware, and the two devices in front of them."""

from dataclasses import dataclass, replace

from drivers.ati.settings import ForceSensorSettings
from drivers.dynamixel.settings import ServoBusSettings
from model.values.parameters import RobotParameters
from sim_hw.ati.unit import NOISE, VirtualWnet, WnetWire
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.goal_path import GoalPath
from sim_hw.dynamixel.latency_timer import LatencyTimer
from sim_hw.dynamixel.old_servos import OldServos
from sim_hw.faults.mishaps import DisturbedMotors, ServoMishaps
from sim_hw.faults.scenario import Scenario
from sim_hw.faults.servo import FaultyServoWire
from sim_hw.faults.time import ScenarioTime
from sim_hw.faults.wnet import FaultyWnet
from sim_hw.host.imu_lines import ImuSetup, PrintedImu
from sim_hw.host.world import World
from sim_hw.interfaces import HostedWorld, ServoWire
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from sim_hw.twin.motion_capture import MotionCapture
from sim_hw.twin.twin import Twin


@dataclass(frozen=True, slots=True)
class VirtualRobot:
    """The virtual robot's parts.

    Attributes:
        world: Plant and firmware running together in steps, or a bench.
        servos: Virtual servos.
        wnet: Virtual wireless force-torque unit.
        firmware: The servos' control loops.
        servo_wire: The servos as the host's port sees them; with a scenario, its faults lie between.
        wnet_wire: The same for the force-torque unit.
        cameras: What sees body and feet; None where ground truth is taken as it is.
        imu: The IMU on its body, whose clock is the world's; None for none.
    """

    world: HostedWorld
    servos: VirtualServoBus
    wnet: VirtualWnet
    firmware: FirmwareBank
    servo_wire: ServoWire
    wnet_wire: WnetWire
    cameras: MotionCapture | None
    imu: PrintedImu | None = None


def build_virtual_robot(
    robot: RobotParameters,
    servo_bus: ServoBusSettings,
    force_sensor: ForceSensorSettings,
    seed: int,
    twin: Twin | None = None,
    scenario: Scenario | None = None,
    imu: ImuSetup | None = None,
) -> VirtualRobot:
    """Build a virtual robot for a robot file.

    Args:
        robot: Nominal parameters; geometry is copied from them when there is no twin.
        servo_bus: Ids, mounting and baud rate of the servos.
        force_sensor: Transducers and their mounting.
        seed: Seed of all noise.
        twin: What the robot and its sensors really are; None for the nominal robot and ground truth.
        scenario: What goes wrong; None for sound devices with nothing between them and the host.
        imu: The IMU on its body, None for none.
    """
    made = twin.plant if twin is not None else PlantParameters.nominal(robot)
    plant, firmware = Plant(made, seed), FirmwareBank(robot.legs.count, made.drive.loop)
    sensors = twin.sensors if twin is not None else None
    printed = PrintedImu(imu) if imu is not None else None
    watching = printed.imu if printed is not None else None
    world = World(plant, firmware, servo_bus, force_sensor, sensors, watching, seed)
    if twin is not None and GoalPath.needed(twin.plant.drive):
        firmware.goal_path = GoalPath(twin.plant.drive, world.motors().ticks, plant.dt_s, seed)
    robot_there = put_devices(world, firmware, servo_bus, force_sensor, seed, scenario, twin)
    return replace(robot_there, imu=printed)


def put_devices(
    world: HostedWorld,
    firmware: FirmwareBank,
    servo_bus: ServoBusSettings,
    force_sensor: ForceSensorSettings,
    seed: int,
    scenario: Scenario | None,
    twin: Twin | None = None,
) -> VirtualRobot:
    """Put both virtual devices into a world; arguments as for ``build_virtual_robot``.

    Args:
        world: The world.
        firmware: The servos' control loops, which it calls.
        servo_bus: Ids and baud rate of the servos.
        force_sensor: Transducers.
        seed: Seed of all noise.
        scenario: What goes wrong.
        twin: Whose sensors and cameras they are; None for sound ones.
    """
    ids = tuple(int(i) for i in servo_bus.ids)
    transducers = tuple(int(t) for t in force_sensor.transducers)
    noise = NOISE
    if twin is not None and twin.sensors.forces:
        force_n = twin.sensors.noise.force_n
        noise = (force_n, force_n, force_n, *NOISE[3:])
    cameras = MotionCapture(twin.sensors, seed) if twin is not None else None
    assumed = scenario if scenario is not None else Scenario()
    motors = DisturbedMotors(world, firmware)
    seen = world if scenario is None else motors
    servos = VirtualServoBus(
        seen, firmware, ids, servo_bus.baud_rate, assumed.servo, servo_bus.models
    )
    wnet = VirtualWnet(world, transducers, seed=seed, noise=noise, assumed=assumed.force_unit)
    if scenario is None:
        return VirtualRobot(world, servos, wnet, firmware, servos, wnet, cameras)
    time = ScenarioTime(scenario.course.begins)
    mishaps = ServoMishaps(servos, motors, scenario.faults, time)
    return VirtualRobot(
        world=world,
        servos=servos,
        wnet=wnet,
        firmware=firmware,
        servo_wire=faulty_wire(servos, mishaps, scenario, time, servo_bus.baud_rate),
        wnet_wire=FaultyWnet(wnet, scenario.faults, time, scenario.course.seed),
        cameras=cameras,
    )


def faulty_wire(
    servos: VirtualServoBus,
    mishaps: ServoMishaps,
    scenario: Scenario,
    time: ScenarioTime,
    baud_rate: int,
) -> ServoWire:
    """Return the wire to servos with a scenario on it: old servos, faults, adapter, in this order."""
    if scenario.servo.old_firmware:
        servos.join(OldServos(scenario.servo.old_firmware, baud_rate))
    wire = FaultyServoWire(servos, mishaps, scenario.faults, time, scenario.course.seed)
    if scenario.adapter.latency_timer_s > 0:
        return LatencyTimer(wire, scenario.adapter.latency_timer_s)
    return wire
