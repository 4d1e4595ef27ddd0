"""The MuJoCo robot of a robot file as a simulator under diagnosis: a trial's commands, walked again.

The plant begins on its feet, takes the pose of the trial's first commands, is put where the trial began,
and then gets every command at its time. Sensors have no noise, and the robot is the file's own, on no
particular day: two questions alike get the same answer.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from drivers.ati.foot_forces import foot_wrenches
from drivers.dynamixel.joints import angle_to_ticks, ticks_to_angle
from drivers.dynamixel.registers import OperatingMode
from gap.interfaces import Cause
from gap.interfaces import Effect as GapEffect
from gap.machines.mujoco.simulator import RolloutSimulator
from model.effects.catalogue import CATALOGUE
from model.effects.leg_kinds import check_effects, why_not
from model.effects.machine import parse_machine
from model.errors import ConfigError, GapError
from model.motion.attitude import roll_pitch_yaw
from model.values.arrays import FloatArray, readonly
from record.trial.header import TrialNoise
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig, parse_robot
from robot.virtual.file_twin import file_effects, nominal_twin, twin_effects
from robot.virtual.twin_run import body_of, poses_of
from sim_hw.host.virtual_robot import build_virtual_robot
from sim_hw.host.world import World
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import apply_effects
from sim_hw.twin.motion_capture import MotionCapture
from sim_hw.twin.twin import Twin

NAME = "mujoco"
SEED = 0
STILL = TrialNoise(0.0, 0.0, 0.0, 0.0, 0.0)
TURN = 2 * np.pi
RAMP_S, SETTLE_S, STEP_S = 1.5, 0.5, 0.01
START_NS = 1_000_000_000


def twin_catalogue() -> tuple[GapEffect, ...]:
    """Return the effects of the catalogue that the MuJoCo robot can have more or less of, in its bounds."""
    kinds = {kind.name: kind for kind in EFFECTS if kind.apply is not None}
    effects = []
    for effect in CATALOGUE:
        kind = kinds.get(effect.name)
        if kind is None:
            continue  # Coulomb's law and the tilt coupling: every MuJoCo robot has them
        bounds = {p.name: (p.low, p.high) for p in kind.parameters}
        parameters = tuple(
            replace(p, lower=max(p.lower, bounds[p.name][0]), upper=min(p.upper, bounds[p.name][1]))
            for p in effect.parameters
        )
        effects.append(replace(effect, parameters=parameters))
    return tuple(effects)


def twin_simulator(text: str, only: tuple[str, ...] = ()) -> RolloutSimulator:
    """Return the simulator of a robot file.

    Args:
        text: The robot file, complete enough to drive.
        only: Names of the effects to look at; all for none.

    Raises:
        GapError: The file cannot be used, or an effect is none of the MuJoCo robot's or of such legs.
    """
    effects = twin_catalogue()
    known = {effect.name for effect in effects}
    for name in only:
        if name not in known:
            raise GapError(
                f"{name!r} is no effect of the MuJoCo robot; bigant sim effects lists them"
            )
    try:
        config = parse_robot(text)
    except ConfigError as error:
        raise GapError(f"--sim mujoco needs a robot file that can be driven: {error}") from error
    leg = config.parameters.leg
    check_effects((Cause(name, (), ()) for name in only), leg)
    fitting = (effect for effect in effects if not why_not(effect.name, leg))
    chosen = tuple(effect for effect in fitting if not only or effect.name in only)
    return RolloutSimulator(NAME, parse_machine(text), chosen, TwinRollout(config))


@dataclass(frozen=True, slots=True)
class TwinRollout:
    """Implements ``gap.machines.mujoco.simulator.Rollout``.

    Attributes:
        config: Robot file.
    """

    config: RobotConfig

    def __call__(self, trial: Trial, causes: tuple[Cause, ...]) -> Trial:
        """Walk a trial's commands with causes added.

        Raises:
            ConfigError: The MuJoCo robot cannot have one of the causes at this size.
        """
        config = self.config
        twin = self._twin(causes)
        robot = build_virtual_robot(
            config.parameters, config.servo_bus, config.force_sensor, SEED, twin
        )
        world, firmware = robot.world, robot.firmware
        assert isinstance(world, World), "a twin is no bench"
        commands = _known(trial.command_rad)
        turns = TURN * np.round(commands[0] / TURN)
        commands = commands - turns
        world.advance_to(START_NS)
        firmware.mode[:] = int(OperatingMode.EXTENDED_POSITION)
        for index, ticks in enumerate(world.motors().ticks):
            firmware.restart(index, float(ticks))
        firmware.goal_position[:] = world.motors().ticks
        firmware.servos["torque"] = True
        now_ns = self._stand_up(world, firmware.goal_position, commands[0])
        _begin_at(world, trial)
        return self._walk(trial, twin, world, firmware.goal_position, commands, turns, now_ns)

    def _twin(self, causes: tuple[Cause, ...]) -> Twin:
        twin = nominal_twin(self.config, SEED)
        twin = replace(twin, sensors=replace(twin.sensors, noise=STILL))
        asked = tuple(effect for cause in causes for effect in twin_effects(cause))
        return apply_effects(twin, (*file_effects(self.config, asked), *asked), EFFECTS)

    def _ticks(self, angle_rad: FloatArray) -> FloatArray:
        bus = self.config.servo_bus
        ticks: FloatArray = angle_to_ticks(angle_rad, bus.signs, bus.zeros).astype(np.float64)
        return ticks

    def _stand_up(self, world: World, goal: FloatArray, first: FloatArray) -> int:
        """Turn the shafts to the first commands, and let what moves come to rest."""
        now_ns = START_NS
        for share in np.linspace(0.0, 1.0, round(RAMP_S / STEP_S)):
            goal[:] = self._ticks(share * first)
            now_ns += round(STEP_S * 1e9)
            world.advance_to(now_ns)
        now_ns += round(SETTLE_S * 1e9)
        world.advance_to(now_ns)
        return now_ns

    def _walk(
        self,
        trial: Trial,
        twin: Twin,
        world: World,
        goal: FloatArray,
        commands: FloatArray,
        turns: FloatArray,
        now_ns: int,
    ) -> Trial:
        bus, unit = self.config.servo_bus, self.config.force_sensor
        times = now_ns + np.rint((trial.time_s - trial.time_s[0]) * 1e9).astype(np.int64)
        shafts, wrenches, places = [], [], []
        for t_ns, command in zip(times.tolist(), commands, strict=True):
            world.advance_to(t_ns)
            shafts.append(ticks_to_angle(world.motors().ticks, bus.signs, bus.zeros))
            wrenches.append(world.wrench(t_ns))
            position, quaternion, feet = world.plant.places()
            places.append((t_ns, position.copy(), quaternion, feet))
            goal[:] = self._ticks(command)
        shaft = np.array(shafts)
        sensed = foot_wrenches(np.array(wrenches), unit, shaft)
        x, y, z = np.moveaxis(sensed[..., :3], -1, 0)
        y, z = unit.up * y, unit.up * z
        c, s = np.cos(unit.yaw_rad), np.sin(unit.yaw_rad)
        measured = MotionCapture(twin.sensors, SEED).see_all(poses_of(places))
        body, angles, foot = body_of(measured)
        # the encoder scales the turns that were left out as it scales the others
        return replace(
            trial,
            shaft_rad=readonly(shaft + turns * twin.sensors.encoder_scale),
            force_n=readonly(np.stack([c * x - s * y, s * x + c * y, z], axis=-1)),
            body_position_m=readonly(body),
            body_angles_rad=readonly(angles),
            foot_m=readonly(foot),
        )


def _known(commands: FloatArray) -> FloatArray:
    """Commands without gaps: one that is missing is the one before.

    Raises:
        GapError: A leg has none at all.
    """
    if not np.isfinite(commands).any(axis=0).all():
        raise GapError("--sim mujoco needs the commands of every leg; these runs do not have them")
    at = np.arange(len(commands))
    filled = [
        np.interp(at, at[np.isfinite(column)], column[np.isfinite(column)]) for column in commands.T
    ]
    return np.stack(filled, axis=1)


def _begin_at(world: World, trial: Trial) -> None:
    """Put the robot where the trial began, as the cameras have it; the origin if they do not say."""
    start = np.array([*trial.body_position_m[0, :2], trial.body_angles_rad[0, 2]])
    start = np.where(np.isfinite(start), start, 0.0)
    state = world.plant.data.qpos
    turned = Rotation.from_quat(np.roll(state[3:7], -1))
    yaw = roll_pitch_yaw(turned)[2]
    state[0:2] = start[:2]
    state[3:7] = np.roll((Rotation.from_euler("z", start[2] - yaw) * turned).as_quat(), 1)
    world.plant.refresh()
