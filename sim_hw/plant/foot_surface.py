"""Friction that is more than one number a foot: it depends on speed, place, time and direction.

Coefficients are written into MuJoCo's model before each of its steps; direction, which MuJoCo's contacts
know only in axes of their own, by turning those axes between collision and constraints.
"""

import math

import mujoco
import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.values.arrays import BoolArray, FloatArray, IntArray
from sim_hw.plant.parameters import PlantParameters

# A foot clings to the ground while it is as near as this [m].
CLING_M = 0.001


@in_place
@compiled
def surface(
    time_s: float,
    settings: FloatArray,
    mu: FloatArray,
    fade_s: FloatArray,
    adhesion: FloatArray,
    normal: FloatArray,
    place: FloatArray,
    velocity: FloatArray,
    friction: FloatArray,
    cling: FloatArray,
) -> None:
    """Write the coefficient of every foot and the force with which it clings.

    Args:
        time_s: Since the beginning.
        settings: Static ratio, its speed, patch ratio, its x, floor of fading, (5,).
        mu: Coefficients when sliding, (N,).
        fade_s: Time constants of fading, (N,).
        adhesion: Clinging forces, (N,).
        normal: Of the ground, world axes, (3,).
        place: Feet in the world, (N, 3).
        velocity: Of the feet over the ground, (N, 3).
        friction: Coefficients now, (N,); changed.
        cling: Force along the ground's normal on each foot, (N,); changed.
    """
    for k in range(len(mu)):
        value = mu[k]
        if place[k, 0] > settings[3]:
            value *= settings[2]
        if math.isfinite(fade_s[k]):
            value *= settings[4] + (1.0 - settings[4]) * math.exp(-time_s / fade_s[k])
        if settings[0] != 1.0:
            speed = math.hypot(velocity[k, 0], velocity[k, 1])
            value *= 1.0 + (settings[0] - 1.0) * math.exp(-speed / settings[1])
        friction[k] = value
        height = place[k, 0] * normal[0] + place[k, 1] * normal[1] + place[k, 2] * normal[2]
        cling[k] = -adhesion[k] if height < CLING_M else 0.0


@in_place
@compiled
def feet_now(
    places: FloatArray,
    foot_body: IntArray,
    torso: FloatArray,
    rate: FloatArray,
    foot_v: IntArray,
    rotation: FloatArray,
    place: FloatArray,
    velocity: FloatArray,
) -> None:
    """Write the feet and their velocities, world axes.

    Args:
        places: MuJoCo's ``xpos``.
        foot_body: Rows of the feet in it, (N,).
        torso: Its row of the torso, (3,).
        rate: MuJoCo's ``qvel``: of the torso in world axes, its spin in its own, slides in its own.
        foot_v: Addresses of the feet's x, y, z in it, (N, 3).
        rotation: Body to world, (3, 3).
        place: Changed, (N, 3).
        velocity: Changed, (N, 3).
    """
    spin_x = rotation[0, 0] * rate[3] + rotation[0, 1] * rate[4] + rotation[0, 2] * rate[5]
    spin_y = rotation[1, 0] * rate[3] + rotation[1, 1] * rate[4] + rotation[1, 2] * rate[5]
    spin_z = rotation[2, 0] * rate[3] + rotation[2, 1] * rate[4] + rotation[2, 2] * rate[5]
    for k in range(len(foot_v)):
        x, y, z = rate[foot_v[k, 0]], rate[foot_v[k, 1]], rate[foot_v[k, 2]]
        for i in range(3):
            place[k, i] = places[foot_body[k], i]
        ax, ay, az = place[k, 0] - torso[0], place[k, 1] - torso[1], place[k, 2] - torso[2]
        velocity[k, 0] = spin_y * az - spin_z * ay
        velocity[k, 1] = spin_z * ax - spin_x * az
        velocity[k, 2] = spin_x * ay - spin_y * ax
        for i in range(3):
            slide = rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2] * z
            velocity[k, i] += rate[i] + slide


@in_place
@compiled
def foot_arms(places: FloatArray, foot_body: IntArray, torso: FloatArray, arms: FloatArray) -> None:
    """Write the ways from the torso's origin to the feet, world axes, (N, 3); see ``feet_now``."""
    for k in range(len(foot_body)):
        for i in range(3):
            arms[k, i] = places[foot_body[k], i] - torso[i]


@in_place
@compiled
def feet_truth(
    places: FloatArray,
    foot_body: IntArray,
    torso: FloatArray,
    rate: FloatArray,
    foot_v: IntArray,
    rotation: FloatArray,
    force: FloatArray,
    least_n: float,
    feet: FloatArray,
    contact: BoolArray,
) -> None:
    """Write all that is known of the feet.

    Args:
        places: Of ``feet_now``, as all up to ``rotation``.
        foot_body: Rows.
        torso: Row.
        rate: Speeds.
        foot_v: Addresses.
        rotation: Body to world.
        force: Ground's force on each foot, body axes, (N, 3) [N].
        least_n: What a foot carries that is not in the air [N].
        feet: Places and velocities, world axes, and forces, (3, N, 3); changed.
        contact: Whether each foot carries more than that, (N,); changed.
    """
    feet_now(places, foot_body, torso, rate, foot_v, rotation, feet[0], feet[1])
    for k in range(len(foot_body)):
        for i in range(3):
            feet[2, k, i] = force[k, i]
        contact[k] = force[k, 2] > least_n


def prepare() -> None:
    """Load or make the machine code, so that no step waits for it."""
    compile_for(surface, NUMBER, *given(1, 1, 1, 1, 1, 2, 2), *out(1, 1))
    compile_for(
        feet_now, *given(2), *given(1, kind=COUNT), *given(1, 1), *given(2, kind=COUNT), *given(2),
        *out(2, 2),
    )  # fmt: skip
    compile_for(foot_arms, *given(2), *given(1, kind=COUNT), *given(1), *out(2))
    compile_for(
        feet_truth, *given(2), *given(1, kind=COUNT), *given(1, 1), *given(2, kind=COUNT),
        *given(2, 2), NUMBER, *out(3), *out(1, kind=FLAG),
    )  # fmt: skip


def surface_settings(plant: PlantParameters) -> FloatArray:
    """Return ``settings`` of ``surface``."""
    f = plant.friction
    return np.array([f.static_ratio, f.static_speed, f.patch_ratio, f.patch_x, f.fade_floor])


def varies(plant: PlantParameters) -> bool:
    """Whether coefficients change, or feet cling, in the course of a run."""
    f = plant.friction
    changing = f.static_ratio != 1.0 or f.patch_ratio != 1.0
    return bool(changing or np.isfinite(f.fade_s).any() or (f.adhesion > 0).any())


class DirectedContacts:
    """MuJoCo's step with contact axes turned to the directions of the feet's friction.

    The force bound of a sliding foot is an ellipse: mu (1 + |w|^2) along w, mu across it.

    Args:
        plant: Its anisotropy.
        leg_of_geom: Leg of each geom, -1 for none.
    """

    def __init__(self, plant: PlantParameters, leg_of_geom: IntArray) -> None:
        w = plant.friction.anisotropy
        self._size = 1.0 + (w**2).sum(axis=1)
        self._bearing = np.arctan2(w[:, 1], w[:, 0])
        self._turned: BoolArray = self._size > 1.0
        self._leg_of_geom = leg_of_geom

    @property
    def any(self) -> bool:
        """Whether any foot's friction has a direction."""
        return bool(self._turned.any())

    def step(self, model: mujoco.MjModel, data: mujoco.MjData, yaw_rad: float) -> None:
        """Take one MuJoCo step.

        Args:
            model: The model.
            data: The state.
            yaw_rad: Of the body in the world.
        """
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        mujoco.mj_collision(model, data)
        self._turn(data, yaw_rad)
        mujoco.mj_makeConstraint(model, data)
        mujoco.mj_island(model, data)
        mujoco.mj_projectConstraint(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_step2(model, data)

    def _turn(self, data: mujoco.MjData, yaw_rad: float) -> None:
        if data.ncon == 0:
            return
        contact = data.contact
        for at, leg in enumerate(self._leg_of_geom[contact.geom[:, 1]]):
            if leg < 0 or not self._turned[leg]:
                continue
            axes = contact.frame[at].reshape(3, 3)
            bearing = self._bearing[leg] + yaw_rad
            along = np.array([np.cos(bearing), np.sin(bearing), 0.0])
            along -= axes[0] * (axes[0] @ along)
            axes[1] = along / np.linalg.norm(along)
            axes[2] = np.cross(axes[0], axes[1])
            contact.friction[at, 0] *= self._size[leg]
