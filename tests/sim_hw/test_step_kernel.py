"""Steps in one compiled call are the same bit for bit as steps one at a time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.dynamixel.registers import OperatingMode
from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot
from sim_hw.assumed import ImuAssumed
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.host import world as world_module
from sim_hw.host.world import KEPT_STEPS, World
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from sim_hw.plant.structure import GearSide, LoopKind, ServoLoop
from sim_hw.twin.imu import VirtualImu

CONFIG = load_robot(Path("config/bigant.toml"))
NOMINAL = PlantParameters.nominal(CONFIG.parameters)
LEGS = NOMINAL.legs
SOFT = replace(NOMINAL.drive, compliance=np.full(LEGS, 0.01), backlash=np.full(LEGS, 0.02))
LOOP = ServoLoop(
    kind=LoopKind.CASCADED, angle_gain=20.0, speed_gain=0.2, feedback=GearSide.SHAFT,
    encoder=GearSide.MOTOR,
)  # fmt: skip
PLANTS = {
    "nominal": NOMINAL,
    "soft drive": replace(NOMINAL, drive=SOFT),
    "cascaded loop": replace(NOMINAL, drive=replace(SOFT, loop=LOOP)),
    "rolling soles": replace(NOMINAL, rolling_radius=0.05),
    "one substep": replace(NOMINAL, substeps=1, servo_substeps=4),
}


def walked(parameters: PlantParameters) -> tuple[FloatArray, ...]:
    """Return what a walk of 0.4 s leaves behind: truth, forces, motors, wrenches, IMU."""
    plant = Plant(parameters, 3)
    firmware = FirmwareBank(LEGS, parameters.drive.loop)
    imu = VirtualImu(ImuAssumed(), 5)
    world = World(plant, firmware, CONFIG.servo_bus, CONFIG.force_sensor, imu=imu)
    world.advance_to(0)
    firmware.mode[:] = int(OperatingMode.EXTENDED_POSITION)
    firmware.goal_position[:] = world.motors().ticks
    firmware.servos["torque"] = True
    wrenches = []
    for tick in range(40):
        firmware.goal_position[:] += 30.0 * np.sin(0.2 * tick + np.arange(LEGS))
        firmware.servos["torque"][2] = tick < 30
        world.advance_to(10_000_000 * tick + 3_300_000)
        wrenches.append(world.wrench(10_000_000 * tick + 7_100_000))
    truth = world.truth(400_000_000)
    readings = np.array([[one.t_ns, one.yaw_rate_rad_s] for one in imu.arrived(10**10)])
    return (
        truth.position_W, truth.foot_force_B, truth.velocity_B, *world.motors(),
        np.array(wrenches), world._forces[: KEPT_STEPS // 8], readings, plant.data.qpos.copy(),
    )  # fmt: skip


@pytest.mark.parametrize("name", PLANTS)
def test_compiled_steps_are_those_taken_one_at_a_time(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_once = walked(PLANTS[name])
    monkeypatch.setattr(world_module, "compiles", lambda: False)
    one_by_one = walked(PLANTS[name])
    for made, expected in zip(at_once, one_by_one, strict=True):
        np.testing.assert_array_equal(made, expected)
    assert np.abs(at_once[0]).max() > 0.01


def test_what_is_out_of_the_way_is_stepped_one_at_a_time() -> None:
    friction = replace(NOMINAL.friction, static_ratio=1.3)
    assert Plant(NOMINAL).plain
    assert not Plant(replace(NOMINAL, friction=friction)).plain
    assert not Plant(replace(NOMINAL, disturbance=replace(NOMINAL.disturbance, gust=1.0))).plain
