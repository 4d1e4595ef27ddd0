"""The plant: the physical robot on the ground, in MuJoCo, driven by motor duties.

It has inertia, leg springs with dampers, Coulomb friction that sticks, and servos with torque-speed
limits: none of which the model of ``model/`` has. It never calls that model.
"""

from dataclasses import replace

import mujoco
import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.readings import BodyTruth
from sim_hw.plant import foot_surface, leg_kernel
from sim_hw.plant.ballast import (
    TEST_FROM_M_S,
    TEST_HOLD,
    TEST_LONGEST_S,
    TEST_MASSES,
    TEST_SLIP_M_S,
    TEST_TO_M_S,
    Ballast,
)
from sim_hw.plant.foot_surface import (
    DirectedContacts,
    feet_now,
    feet_truth,
    foot_arms,
    surface,
    surface_settings,
    varies,
)
from sim_hw.plant.leg_kernel import (
    CURRENT,
    JAM,
    MOTOR,
    MOTOR_RATE,
    SHAFT,
    SHAFT_RATE,
    STATE_NUMBERS,
    SUPPLY,
    TEMPERATURE,
    leg_rows,
    turn_legs,
)
from sim_hw.plant.leg_path import foot_path, leg_geometry, leg_point
from sim_hw.plant.motor import motor_row
from sim_hw.plant.mujoco_model import build_model, ground_axes
from sim_hw.plant.parameters import Disturbance, GroundParameters, PlantParameters
from sim_hw.plant.shaft_friction import shaft_friction

SETTLING_S = 1.5
# A foot that carries less than this is in the air.
CONTACT_FORCE_N = 1e-3
SCALAR_LAST = np.array([1, 2, 3, 0])  # of a quaternion, which MuJoCo has with its scalar first


class Plant:
    """The robot, standing on all feet at shaft angle 0 to begin with.

    Args:
        parameters: What it is made of.
        seed: Seed of what is random in the plant: gusts. The sensors have their own.

    Attributes:
        leg_state: What ``leg_kernel`` keeps of each leg, (N, 8); the next seven are its columns.
        shaft_angle_rad: Shaft angles as the encoders have them, unwrapped, (N,); all views of what is now.
        shaft_rate_rad_s: Shaft speeds, (N,).
        motor_angle_rad: Motor angles, seen at the output; the shafts' own unless gears twist or have play.
        motor_rate_rad_s: Motor speeds, seen at the output, (N,).
        current_a: Motor currents, (N,).
        temperature_c: Motor temperatures, (N,).
        supply_v: Voltage at each servo, (N,).
        jam_n_m: Dry friction of each shaft beside its motor's: its own, and of what is caught, (N,).
        foot_force_B: Ground's force on each foot in the last step, body axes, (N, 3) [N].
    """

    def __init__(self, parameters: PlantParameters, seed: int = 0) -> None:
        foot_surface.prepare()
        leg_kernel.prepare()
        p = self.parameters = parameters
        legs = range(p.legs)
        model = self.model = build_model(p)
        data = self.data = mujoco.MjData(model)
        self._qpos, self._qvel, self._applied = data.qpos, data.qvel, data.qfrc_applied
        axes = [[f"{axis}_{k}" for axis in "xyz"] for k in legs]
        joints = [[model.joint(name) for name in names] for names in axes]
        self._foot_q = np.array([[int(one.qposadr[0]) for one in leg] for leg in joints])
        self._foot_v = np.array([[int(one.dofadr[0]) for one in leg] for leg in joints])
        # the contacts' force on the slides is the ground's on the feet, body axes; a view where it can be
        ends = int(self._foot_v.min()), int(self._foot_v.max()) + 1
        together = np.array_equal(self._foot_v.ravel(), np.arange(*ends))
        self._reaction = data.qfrc_constraint[slice(*ends)].reshape(p.legs, 3) if together else None
        self._roll_v = np.full(p.legs, -1)
        for k in np.flatnonzero(p.turning_radius > 0).tolist():
            self._roll_v[k] = model.joint(f"roll_{k}").dofadr[0]
        self._xpos = data.xpos
        self._foot_body = np.array([model.body(f"foot_{k}").id for k in legs])
        self._foot_parent = model.body_parentid[self._foot_body]
        self._geoms = np.array([model.geom(f"foot_{k}").id for k in legs])
        leg_of_geom = np.full(model.ngeom, -1)
        leg_of_geom[self._geoms] = np.arange(p.legs)
        torso = self._torso = model.body("torso").id
        # views of what is now, as the rest of MuJoCo's state
        self._torso_position: FloatArray = data.xpos[torso]
        self._torso_quaternion: FloatArray = data.xquat[torso]
        self._torso_turn: FloatArray = data.xmat[torso].reshape(3, 3)
        self._velocity: FloatArray = data.qvel[0:3]
        self._spin: FloatArray = data.qvel[3:6]
        self._geometry = leg_geometry(p)
        zero = np.array([leg_point(g, 0.0)[4] for g in self._geometry])
        self._rows, self._motors = leg_rows(p, zero), np.array([motor_row(one) for one in p.motors])
        self._own_friction_n_m = shaft_friction(p)
        self.jam_n_m: FloatArray = self._rows[:, JAM]
        self.jam_n_m[:] = self._own_friction_n_m
        state = self.leg_state = np.zeros((p.legs, STATE_NUMBERS))
        self.shaft_angle_rad: FloatArray = state[:, SHAFT]
        self.shaft_rate_rad_s: FloatArray = state[:, SHAFT_RATE]
        self.motor_angle_rad: FloatArray = state[:, MOTOR]
        self.motor_rate_rad_s: FloatArray = state[:, MOTOR_RATE]
        self.current_a: FloatArray = state[:, CURRENT]
        self.temperature_c: FloatArray = state[:, TEMPERATURE]
        self.supply_v: FloatArray = state[:, SUPPLY]
        self._directed = DirectedContacts(p, leg_of_geom)
        self._varies, self._has_direction = varies(p), self._directed.any
        self._settings, self._normal = surface_settings(p), ground_axes(p)[:, 2].copy()
        self._coefficients, self._cling = np.zeros(p.legs), np.zeros(p.legs)
        self._clings = bool(p.friction.adhesion.any())
        self._gusts = Gusts(p.disturbance, p.time_step_s, seed)
        self._steady = not (self._varies or self._has_direction or self._gusts.blow)
        self._push, self._gust = np.zeros(6), np.zeros(2)
        self._ballast: Ballast | None = None
        self.foot_force_B: FloatArray = np.zeros((p.legs, 3))
        self._stand()
        if p.ballast_s > 0:
            self._ballast = ballast_of(p)

    def jam(self, index: int, torque_n_m: float) -> None:
        """Give a shaft so much dry friction on top of its own; 0 frees it."""
        self.jam_n_m[index] = self._own_friction_n_m[index] + torque_n_m

    @property
    def dt_s(self) -> float:
        """Step of ``step``."""
        return self.parameters.time_step_s

    @property
    def torso_rotation(self) -> FloatArray:
        """Body to world, (3, 3), as of the last call of ``refresh`` or ``truth``."""
        return self._torso_turn

    @property
    def feet_B(self) -> FloatArray:  # noqa: N802 - frame suffix
        """Feet in the body frame, (N, 3) [m]."""
        self.refresh()
        feet: FloatArray = self._arms().dot(self._torso_turn)
        return feet

    def _arms(self) -> FloatArray:
        """From the torso's origin to the feet, world axes, (N, 3) [m]."""
        arms = np.empty((self.parameters.legs, 3))
        foot_arms(self._xpos, self._foot_body, self._torso_position, arms)
        return arms

    def refresh(self) -> None:
        """Bring MuJoCo's places of bodies up to date with its state."""
        mujoco.mj_kinematics(self.model, self.data)

    def _stand(self) -> None:
        """Stand on all feet, springs loaded, and let what is left of it die away."""
        p = self.parameters
        angle = np.zeros(p.legs)
        _, z, _, _ = foot_path(p, angle + p.drive.crank_offset)
        sag = p.mass * p.gravity / p.stiffness.sum()
        lowest = (z - p.leg_offset).min()
        self.place(height_m=float(-lowest - sag), angle_rad=angle)
        off = np.zeros(p.legs, dtype=bool)
        for _ in range(round(SETTLING_S / p.time_step_s)):
            self.step(angle, off)
        # begin at the world's origin; the ground rises with the slope
        rise = self._normal[:2] @ self._qpos[0:2] / self._normal[2]
        self._qpos[2] += rise
        self._qpos[0:2] = 0.0
        self.data.time = 0.0
        self.refresh()

    def place(self, height_m: float, angle_rad: FloatArray) -> None:
        """Put the body along the ground at a height over the world's origin, at rest, shafts as given."""
        p = self.parameters
        mujoco.mj_resetData(self.model, self.data)
        axes = ground_axes(p)
        self._qpos[0:3] = axes[:, 2] * height_m
        mujoco.mju_mat2Quat(self._qpos[3:7], axes.ravel())
        self.leg_state[:] = 0.0
        self.motor_angle_rad[:] = self.shaft_angle_rad[:] = angle_rad
        self.temperature_c[:] = [motor.ambient_c for motor in p.motors]
        self.supply_v[:] = [motor.battery_v for motor in p.motors]
        x, z, _, _ = foot_path(p, angle_rad + p.drive.crank_offset)
        self._qpos[self._foot_q[:, 0]], self._qpos[self._foot_q[:, 2]] = x, z - p.leg_offset
        self.push(np.zeros(3), np.zeros(3))
        self.refresh()

    def step(self, duty: FloatArray, driven: BoolArray) -> None:
        """Advance by one step.

        Args:
            duty: PWM duty of each motor in the leg's sense, -1 to 1, (N,).
            driven: False where the output stage is off, (N,).
        """
        p, model, data = self.parameters, self.model, self.data
        dt_s = p.time_step_s / p.substeps
        force = np.zeros(self.foot_force_B.shape)
        if self._gusts.blow:
            self._gust = self._gusts.next()
            self._write_push(self._gust)
        for _ in range(p.substeps):
            turn_legs(
                dt_s, p.servo_substeps, self._motors, self._geometry, self._rows, self.leg_state, duty,
                driven, self._foot_q, self._foot_v, self._roll_v, self._qpos, self._qvel, self._applied,
            )  # fmt: skip
            if self._varies:
                self._change_surface()
            if self._ballast is not None:
                self._tow(self._ballast)
            if self._has_direction:
                self._directed.step(model, data, self._yaw_rad())
            else:
                mujoco.mj_step(model, data)
            reaction = self._reaction
            force = force + (data.qfrc_constraint[self._foot_v] if reaction is None else reaction)
            if self._clings:  # the ground pulls as well as it pushes
                force += self._cling[:, None] * (self._normal @ self._torso_turn)
        self.foot_force_B = force / p.substeps

    @property
    def plain(self) -> bool:
        """Whether a step is nothing but legs and MuJoCo: no gusts, ballast or changing friction."""
        return self._steady and self._ballast is None

    def leg_arguments(self) -> tuple[FloatArray | IntArray, ...]:
        """Return what ``turn_legs`` takes of this plant, but for duties and steps, in its order."""
        feet = self._foot_q, self._foot_v, self._roll_v
        mujocos = self._qpos, self._qvel, self._applied
        return self._motors, self._geometry, self._rows, self.leg_state, *feet, *mujocos

    def hitch(self, ballast: Ballast) -> None:
        """Let the body tow a ballast from now on."""
        self._ballast = ballast

    def _tow(self, ballast: Ballast) -> None:
        yaw = self._yaw_rad()
        centre = self.data.xipos[self._torso]
        x, y = centre[:2] - self.data.xpos[self._torso, :2]
        spin = float(self.torso_rotation[2] @ self._qvel[3:6])
        rate = self._qvel[:2] + spin * np.array([-y, x])
        force = ballast.pull(np.array([*centre[:2], yaw]), np.array([*rate, spin]))
        on_torso = self.data.xfrc_applied[self._torso]
        self._write_push(self._gust)
        on_torso[[0, 1, 5]] += force

    def _change_surface(self) -> None:
        p = self.parameters
        place, velocity = np.empty((2, p.legs, 3))
        self._write_feet(place, velocity)
        surface(
            self.data.time, self._settings, p.mu, p.friction.fade_s, p.friction.adhesion,
            self._normal, place, velocity, self._coefficients, self._cling,
        )  # fmt: skip
        self.model.geom_friction[self._geoms, 0] = self._coefficients
        if self._clings:
            self.data.xfrc_applied[self._foot_body, :3] = self._cling[:, None] * self._normal

    def _yaw_rad(self) -> float:
        w, x, y, z = self._qpos[3:7]
        return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    def push(self, force_W: FloatArray, torque_W: FloatArray) -> None:  # noqa: N803
        """Keep pushing the torso at its centre of mass, world axes, until told otherwise."""
        self._push[:3], self._push[3:] = force_W, torque_W
        self._write_push(np.zeros(2))

    def _write_push(self, gust: FloatArray) -> None:
        pull = self.parameters.disturbance
        self.data.xfrc_applied[self._torso] = self._push
        self.data.xfrc_applied[self._torso, :2] += [pull.pull_x + gust[0], pull.pull_y + gust[1]]

    def _write_feet(self, place: FloatArray, velocity: FloatArray) -> None:
        """Write the feet and their velocities, world axes, (N, 3) each."""
        feet_now(
            self._xpos, self._foot_body, self._torso_position, self._qvel, self._foot_v,
            self._torso_turn, place, velocity,
        )  # fmt: skip

    def places(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the body's position and quaternion x y z w, and the feet, in the world."""
        self.refresh()
        quaternion = self._torso_quaternion.take(SCALAR_LAST)
        return self._torso_position, quaternion, self._xpos.take(self._foot_body, axis=0)

    def marker_places(self, share: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the same, the feet as markers show that go along with a share of their legs' give."""
        position, quaternion, feet = self.places()
        if share == 1.0:
            return position, quaternion, feet
        p = self.parameters
        give = self._qpos[self._foot_q].copy()  # from the end of the linkage to the foot, body axes
        x, z, _, _ = foot_path(p, self.shaft_angle_rad + p.drive.crank_offset)
        give[:, 0] -= x
        give[:, 2] -= z
        turns = self.data.xmat[self._foot_parent].reshape(-1, 3, 3)
        markers: FloatArray = feet - (1.0 - share) * np.einsum("nij,nj->ni", turns, give)
        return position, quaternion, markers

    def truth(self, t_ns: int) -> BodyTruth:
        """Return where everything is."""
        self.refresh()
        legs = self.parameters.legs
        feet, contact = np.empty((3, legs, 3)), np.empty(legs, np.bool_)
        feet_truth(
            self._xpos, self._foot_body, self._torso_position, self._qvel, self._foot_v,
            self._torso_turn, self.foot_force_B, CONTACT_FORCE_N, feet, contact,
        )  # fmt: skip
        readonly(feet)
        return BodyTruth(
            t_ns=t_ns,
            position_W=readonly(self._torso_position.copy()),
            quaternion_xyzw=readonly(self._torso_quaternion.take(SCALAR_LAST)),
            velocity_B=readonly(self._velocity.dot(self._torso_turn)),
            angular_velocity_B=readonly(self._spin.copy()),
            foot_position_W=feet[0],
            foot_velocity_W=feet[1],
            foot_force_B=feet[2],
            contact=readonly(contact),
        )


class Gusts:
    """A horizontal force that wanders: a first-order random process, the same for the same seed.

    Args:
        disturbance: Its size and correlation time.
        dt_s: Step.
        seed: Seed.
    """

    def __init__(self, disturbance: Disturbance, dt_s: float, seed: int) -> None:
        self.blow = disturbance.gust > 0
        self._keep = np.exp(-dt_s / disturbance.gust_time)
        self._kick = disturbance.gust * np.sqrt(1 - self._keep**2)
        self._random = np.random.default_rng([seed, 0x67])
        self._force = np.zeros(2)

    def next(self) -> FloatArray:
        """Return the force in the next step, world x and y, (2,) [N]."""
        self._force = self._keep * self._force + self._kick * self._random.standard_normal(2)
        return self._force


def ballast_of(plant: PlantParameters) -> Ballast:
    """Return the ballast that the plant's sliding feet bring to a slip of 20 mm/s in its ``ballast_s``.

    The friction of all feet is measured by a pull test: the robot stands, a sledge of known mass that
    slides at 40 mm/s is hitched to it, and feet that slide brake the sledge.
    """
    ground = GroundParameters(np.zeros(2), plant.ground.stiffness)
    robot = Plant(replace(plant, ballast_s=0.0, ground=ground, disturbance=Disturbance()))
    own = plant.mass, float(plant.inertia[2])
    radius = float(np.hypot(*plant.shaft_position[:, :2].T).mean())
    dt_s = plant.time_step_s / plant.substeps
    mass = TEST_MASSES * plant.mass
    sledge = Ballast(mass, radius, own, dt_s)
    sledge.rate = np.array([TEST_FROM_M_S + TEST_SLIP_M_S / 2, 0.0, 0.0])
    robot.data.qvel[0] = sledge.rate[0]
    robot.hitch(sledge)
    on = np.ones(plant.legs, dtype=bool)
    times = []
    for limit in (TEST_FROM_M_S, TEST_TO_M_S):
        while sledge.rate[0] > limit:
            robot.step(-TEST_HOLD * robot.motor_angle_rad, on)
            if robot.data.time > TEST_LONGEST_S:
                raise ModelError("inertia_lag needs feet with friction: they do not brake a sledge")
        times.append(robot.data.time)
    friction = mass * TEST_SLIP_M_S / (times[1] - times[0])  # [N]
    return Ballast(friction * plant.ballast_s / TEST_SLIP_M_S, radius, own, dt_s)
