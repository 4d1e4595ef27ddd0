"""The plant: the physical robot on the ground, in MuJoCo, driven by motor duties.

It has inertia, leg springs with dampers, Coulomb friction that sticks, and servos with torque-speed
limits: none of which the model of ``model/`` has. It never calls that model.
"""

import mujoco
import numpy as np

from model.signals import BodyTruth, BoolArray, FloatArray, readonly
from sim_hw.four_bar import foot_path
from sim_hw.motor import Motors, friction_budget
from sim_hw.plant_model import build_model
from sim_hw.plant_parameters import PlantParameters

SETTLING_S = 1.5
# A foot that carries less than this is in the air.
CONTACT_FORCE_N = 1e-3


class Plant:
    """The robot, standing on all feet at shaft angle 0 to begin with.

    Args:
        parameters: What it is made of.
        seed: Seed of all noise in the plant (none so far; the sensors have their own).
    """

    def __init__(self, parameters: PlantParameters, seed: int = 0) -> None:
        self.parameters = parameters
        self.seed = seed
        self.model = build_model(parameters)
        self.data = mujoco.MjData(self.model)
        legs = range(parameters.legs)
        model = self.model
        self._shaft_q = np.array([model.joint(f"shaft_{k}").qposadr[0] for k in legs])
        self._shaft_v = np.array([model.joint(f"shaft_{k}").dofadr[0] for k in legs])
        self._x_q = np.array([model.joint(f"x_{k}").qposadr[0] for k in legs])
        self._z_q = np.array([model.joint(f"z_{k}").qposadr[0] for k in legs])
        self._x_eq = np.array([model.equality(f"x_{k}").id for k in legs])
        self._z_eq = np.array([model.equality(f"z_{k}").id for k in legs])
        self._foot_body = np.array([model.body(f"foot_{k}").id for k in legs])
        geoms = [model.geom(f"foot_{k}").id for k in legs]
        self._leg_of_geom = np.full(model.ngeom, -1)
        self._leg_of_geom[geoms] = np.arange(parameters.legs)
        self._torso = model.body("torso").id
        self.motors = Motors(
            parameters.motor,
            parameters.legs,
            parameters.battery_v,
            parameters.battery_resistance,
            parameters.ambient_c,
        )
        self.foot_force_W: FloatArray = np.zeros((parameters.legs, 3))
        # dry friction of each shaft on top of its motor's own: what is caught in a leg [N m]
        self.jam_n_m: FloatArray = np.zeros(parameters.legs)
        self._slopes = np.zeros((2, parameters.legs))
        self._stand()

    @property
    def dt_s(self) -> float:
        """Physics step."""
        return self.parameters.time_step_s

    @property
    def shaft_angle_rad(self) -> FloatArray:
        """Shaft angles, unwrapped, (N,)."""
        angles: FloatArray = self.data.qpos[self._shaft_q]
        return angles

    @property
    def shaft_rate_rad_s(self) -> FloatArray:
        """Shaft speeds, (N,)."""
        rates: FloatArray = self.data.qvel[self._shaft_v]
        return rates

    @property
    def torso_rotation(self) -> FloatArray:
        """Body to world, (3, 3)."""
        rotation: FloatArray = self.data.xmat[self._torso].reshape(3, 3)
        return rotation

    @property
    def feet_B(self) -> FloatArray:  # noqa: N802 - frame suffix
        """Feet in the body frame, (N, 3) [m]."""
        relative = self.data.xpos[self._foot_body] - self.data.xpos[self._torso]
        feet: FloatArray = relative @ self.torso_rotation
        return feet

    def _stand(self) -> None:
        """Stand on all feet, springs loaded, and let what is left of it die away."""
        p = self.parameters
        _, z, _, _ = foot_path(p, np.zeros(p.legs))
        sag = p.mass * p.gravity / p.stiffness.sum()
        self.place(height_m=float(-z.min() - sag), angle_rad=np.zeros(p.legs))
        off = np.zeros(p.legs, dtype=bool)
        for _ in range(round(SETTLING_S / p.time_step_s)):
            self.step(np.zeros(p.legs), off)
        self.data.qpos[0:2] = 0.0
        self.data.time = 0.0
        mujoco.mj_step1(self.model, self.data)

    def place(self, height_m: float, angle_rad: FloatArray) -> None:
        """Put the body level at a height over the world's origin, at rest, shafts as given."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[0:7] = [0.0, 0.0, height_m, 1.0, 0.0, 0.0, 0.0]
        self.data.qpos[self._shaft_q] = angle_rad
        x, z, _, _ = foot_path(self.parameters, angle_rad)
        self.data.qpos[self._x_q], self.data.qpos[self._z_q] = x, z
        self._close_loops()
        mujoco.mj_step1(self.model, self.data)

    def _close_loops(self) -> None:
        """Write the tangent of the four-bar at the present shaft angles into the equalities."""
        angle = self.shaft_angle_rad
        x, z, x_slope, z_slope = foot_path(self.parameters, angle)
        eq = self.model.eq_data
        eq[self._x_eq, 0], eq[self._x_eq, 1] = x - x_slope * angle, x_slope
        eq[self._z_eq, 0], eq[self._z_eq, 1] = z - z_slope * angle, z_slope
        self._slopes[0], self._slopes[1] = x_slope, z_slope

    def step(self, duty: FloatArray, driven: BoolArray) -> None:
        """Advance by one physics step.

        Args:
            duty: PWM duty of each motor in the leg's sense, -1 to 1, (N,).
            driven: False where the output stage is off, (N,).
        """
        p, model, data = self.parameters, self.model, self.data
        rate = self.shaft_rate_rad_s
        torque = self.motors.drive(duty, driven, rate, p.time_step_s)
        emf = p.motor.torque_constant**2 / p.motor.resistance  # [N m s]
        force_B = self.foot_force_W @ self.torso_rotation  # noqa: N806 - frame suffix
        load = self._slopes[0] * force_B[:, 0] + self._slopes[1] * force_B[:, 2]
        budget = friction_budget(p.motor, rate, torque - np.where(driven, emf * rate, 0.0), load)
        model.dof_frictionloss[self._shaft_v] = budget + self.jam_n_m
        damping = p.motor.viscous + np.where(driven, emf, 0.0)
        if model.dof_damping.ndim == 2:
            model.dof_damping[self._shaft_v, 0] = damping
        else:
            model.dof_damping[self._shaft_v] = damping
        data.qfrc_applied[self._shaft_v] = torque
        for _ in range(p.substeps - 1):
            mujoco.mj_step2(model, data)
            mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)
        self._read_contacts()
        self._close_loops()
        mujoco.mj_step1(model, data)

    def _read_contacts(self) -> None:
        """Ground's force on each foot, world axes; elliptic cones keep it in contact axes."""
        self.foot_force_W = np.zeros_like(self.foot_force_W)
        contact = self.data.contact
        if self.data.ncon == 0:
            return
        legs = self._leg_of_geom[contact.geom]  # (contacts, 2); the ground's geom comes first
        active = (legs[:, 1] >= 0) & (contact.efc_address >= 0)
        if not active.any():
            return
        rows = contact.efc_address[active, None] + np.arange(3)
        frames = contact.frame[active].reshape(-1, 3, 3)
        forces = np.einsum("ki,kij->kj", self.data.efc_force[rows], frames)
        np.add.at(self.foot_force_W, legs[active, 1], forces)

    def push(self, force_W: FloatArray, torque_W: FloatArray) -> None:  # noqa: N803
        """Keep pushing the torso at its centre of mass, world axes, until told otherwise."""
        self.data.xfrc_applied[self._torso, :3] = force_W
        self.data.xfrc_applied[self._torso, 3:] = torque_W

    def energy_j(self) -> float:
        """Kinetic, gravitational and spring energy."""
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return float(self.data.energy.sum())

    def truth(self, t_ns: int) -> BodyTruth:
        """Return where everything is."""
        data = self.data
        rotation = self.torso_rotation
        quaternion = data.xquat[self._torso]
        velocity = np.zeros((self.parameters.legs, 6))
        kind = mujoco.mjtObj.mjOBJ_XBODY
        for leg, body in enumerate(self._foot_body):
            mujoco.mj_objectVelocity(self.model, data, kind, int(body), velocity[leg], 0)
        return BodyTruth(
            t_ns=t_ns,
            position_W=readonly(data.xpos[self._torso].copy()),
            quaternion_xyzw=readonly(np.roll(quaternion, -1)),
            velocity_B=readonly(data.qvel[0:3] @ rotation),
            angular_velocity_B=readonly(data.qvel[3:6].copy()),
            foot_position_W=readonly(data.xpos[self._foot_body].copy()),
            foot_velocity_W=readonly(velocity[:, 3:].copy()),
            foot_force_B=readonly(self.foot_force_W @ rotation),
            contact=readonly(self.foot_force_W[:, 2] > CONTACT_FORCE_N),
        )
