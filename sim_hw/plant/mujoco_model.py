"""The MuJoCo model of the robot: a free torso, and feet on springs below it.

The end of each leg is where its kind puts it (``sim_hw.plant.leg_path``); the foot hangs from it on
three springs, stiff fore-aft and sideways, soft along z, as three slides in the body frame. So nothing
couples the legs but the body and the ground, there are no constraints but contacts, and a step is cheap.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray
from sim_hw.plant.foot_surface import varies
from sim_hw.plant.leg_kernel import ROLL_INERTIA, ROLLING, side_damping
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.parameters import PlantParameters

# MuJoCo wants some inertia for every moving body; nothing turns the feet.
TOKEN_INERTIA = 1e-7
# Time constant of a contact: two steps, the least MuJoCo allows.
CONTACT_STEPS = 2
# Part of a chassis that twists: mass and inertia of each row of legs but the middle one; assumed.
ROW_MASS = 0.3
ROW_INERTIA = (0.006, 0.002, 0.006)
ROW_DAMPING = 0.5
ROW_APART_M = 0.03  # legs nearer to each other along x are in one row
# Ground that gives: mass that moves with each foot, and damping, share of critical on it.
PAD_MASS = 0.02
PAD_DAMPING_RATIO = 0.5
STEP_LENGTH_M = 5.0
HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
SWEEPS, NEWTON = mujoco.mjtSolver.mjSOL_PGS, mujoco.mjtSolver.mjSOL_NEWTON
ELLIPTIC, PYRAMIDAL = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtCone.mjCONE_PYRAMIDAL


def build_model(plant: PlantParameters) -> mujoco.MjModel:
    """Compile the model. Joints of leg k: x_k, y_k, z_k (roll_k); body, geom and site foot_k."""
    spec = mujoco.MjSpec()
    spec.option.timestep = plant.time_step_s / plant.substeps
    spec.option.gravity = [0.0, 0.0, -plant.gravity]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = ELLIPTIC if plant.contact.elliptic else PYRAMIDAL
    spec.option.impratio = plant.contact.friction_ratio
    # six small contacts: sweeps over their cones take half the time of Newton's method, to the same answer;
    # over pyramids twice
    spec.option.solver = SWEEPS if plant.contact.elliptic else NEWTON
    if plant.contact.elliptic:
        # all hangs from one torso, so there is one island, and sweeps over it are sweeps over everything:
        # the same bits, without the search for islands, a twelfth of a step
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    _add_ground(spec, plant)
    torso = spec.worldbody.add_body()
    torso.name = "torso"
    torso.add_freejoint().name = "free"
    _shape_torso(spec, torso, plant)
    rows = _chassis(torso, plant)
    for leg in range(plant.legs):
        _add_foot(spec, rows[leg], plant, leg)
    if not varies(plant):
        _name_pairs(spec)
    try:
        model = spec.compile()
    except ValueError as error:
        why = " ".join(str(error).split())
        raise ModelError(
            f"the simulator cannot build this robot ({why}); see mass and inertia of its [body]"
        ) from error
    model.dof_damping[0:2] = plant.disturbance.drag
    return model


def ground_axes(plant: PlantParameters) -> FloatArray:
    """Return the ground's axes in the world as columns, (3, 3): x rises with the slope, z is its normal."""
    x = np.array([1.0, 0.0, plant.ground.slope[0]])
    normal = np.array([-plant.ground.slope[0], -plant.ground.slope[1], 1.0])
    x, normal = x / np.linalg.norm(x), normal / np.linalg.norm(normal)
    return np.stack([x, np.cross(normal, x), normal], axis=1)


def _add_ground(spec: "mujoco.MjSpec", plant: PlantParameters) -> None:
    axes = ground_axes(plant)
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, axes.ravel())
    ground = spec.worldbody.add_geom()
    ground.name, ground.type = "ground", mujoco.mjtGeom.mjGEOM_PLANE
    ground.size, ground.quat = [0.0, 0.0, 1.0], quat
    _touch(ground, plant, 1e-6)  # MuJoCo takes the larger of two: the feet decide
    if plant.ground.step_height > 0:
        step = spec.worldbody.add_geom()
        half = STEP_LENGTH_M / 2
        step.name, step.type = "step", mujoco.mjtGeom.mjGEOM_BOX
        step.size, step.quat = [half, half, half], quat
        step.pos = axes @ [plant.ground.step_x + half, 0.0, plant.ground.step_height - half]
        _touch(step, plant, 1e-6)


def _touch(geom: "mujoco.MjsGeom", plant: PlantParameters, friction: float) -> None:
    geom.friction = [friction, 0.0, 0.0]
    least_s = CONTACT_STEPS * plant.time_step_s / plant.substeps
    geom.solref = [max(plant.contact.time_constant_s, least_s), plant.contact.damping_ratio]
    geom.solimp = plant.contact.solimp


def _name_pairs(spec: "mujoco.MjSpec") -> None:
    """Say which geoms may touch, so that MuJoCo does not search for them: a twentieth of a step.

    The same contacts, to the bit: a pair has the larger friction of its two, as MuJoCo would find, and what
    else all geoms have alike. It keeps it, whatever is written to the geoms of the model later on.
    """
    geoms = list(spec.geoms)
    below = [one for one in geoms if one.contype]
    for ground in below:
        for other in [one for one in geoms if one.conaffinity and not one.contype]:
            pair = spec.add_pair()
            pair.geomname1, pair.geomname2 = ground.name, other.name
            friction = max(ground.friction[0], other.friction[0])
            pair.friction = [friction, friction, 0.0, 0.0, 0.0]
            pair.solref, pair.solimp, pair.condim = other.solref, other.solimp, other.condim
    for one in geoms:
        one.contype = one.conaffinity = 0


def _shape_torso(spec: "mujoco.MjSpec", torso: "mujoco.MjsBody", plant: PlantParameters) -> None:
    """Torso with what is left of mass and inertia once feet and rows are subtracted; payload, belly."""
    x, z, _, _ = foot_path(plant, plant.drive.crank_offset)
    feet = plant.shaft_position + np.stack([x, np.zeros(plant.legs), z - plant.leg_offset], axis=1)
    centre = np.array([*plant.com, 0.0])
    parts = [(foot, _foot_mass(plant, leg)) for leg, foot in enumerate(feet)]
    inertia = np.diag(plant.inertia).astype(float)
    if plant.twist > 0:
        others = _row_places(plant)[1:]
        parts += [(np.array([place, 0.0, 0.0]), ROW_MASS) for place in others]
        inertia -= len(others) * np.diag(ROW_INERTIA)
    mass = plant.mass - sum(weight for _, weight in parts)
    torso_at = (plant.mass * centre - sum(weight * point for point, weight in parts)) / mass
    for point, weight in [*parts, (torso_at, mass)]:
        arm = point - centre
        inertia -= weight * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    torso.mass, torso.ipos, torso.explicitinertial = mass, torso_at, True
    torso.fullinertia = [
        inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2],
    ]  # fmt: skip
    if plant.payload > 0:
        load = _part(torso, "payload", plant.payload, [1e-4 * plant.payload] * 3)
        load.pos = [*plant.payload_position, 0.0]
    half = np.abs(plant.shaft_position[:, :2]).max(axis=0)
    belly = torso.add_geom()
    belly.name, belly.type = "belly", mujoco.mjtGeom.mjGEOM_BOX
    belly.size, belly.mass = [half[0], half[1] * 0.8, plant.clearance], 0.0
    _touch(belly, plant, float(plant.mu.mean()))
    belly.contype, belly.conaffinity = 0, 1


def _foot_mass(plant: PlantParameters, leg: int) -> float:
    return plant.foot_mass + (PAD_MASS if np.isfinite(plant.ground.stiffness[leg]) else 0.0)


def _row_of_legs(plant: PlantParameters) -> list[float]:
    """Place along x of the row that each leg is in: the mean of legs that are next to each other."""
    x = plant.shaft_position[:, 0]
    order = np.argsort(x, kind="stable")
    row = np.cumsum(np.diff(x[order], prepend=x[order[0]]) > ROW_APART_M)
    places = np.array([x[order][row == number].mean() for number in range(row[-1] + 1)])
    of_leg = np.empty(len(x))
    of_leg[order] = places[row]
    return [float(place) for place in of_leg]


def _row_places(plant: PlantParameters) -> list[float]:
    """Places of the rows of legs along x, the one nearest the origin first."""
    return sorted(set(_row_of_legs(plant)), key=lambda x: (abs(x), x))


def _chassis(torso: "mujoco.MjsBody", plant: PlantParameters) -> list["mujoco.MjsBody"]:
    """Return the body each leg is fixed to: the torso, or its row of a chassis that twists about x."""
    if plant.twist <= 0:
        return [torso] * plant.legs
    places = _row_places(plant)
    bodies = {places[0]: torso}
    for direction in (1, -1):
        before = places[0]
        for place in sorted(
            (p for p in places if (p - places[0]) * direction > 0), key=lambda p: p * direction
        ):
            row = _part(bodies[before], f"row_{place:g}", ROW_MASS, ROW_INERTIA)
            row.ipos = [place, 0, 0]
            stiffness = max(1, len(places) - 1) / plant.twist
            hinge = _sprung(row, HINGE, f"twist_{place:g}", [1, 0, 0], stiffness, ROW_DAMPING)
            hinge.pos = [(place + before) / 2, 0, 0]
            bodies[place], before = row, place
    return [bodies[x] for x in _row_of_legs(plant)]


def _part(
    parent: "mujoco.MjsBody", name: str, mass: float, inertia: Sequence[float]
) -> "mujoco.MjsBody":
    """Add a body with its centre of mass at its origin."""
    part = parent.add_body()
    part.name, part.mass, part.inertia = name, mass, inertia
    part.ipos, part.explicitinertial = [0, 0, 0], True
    return part


def _sprung(
    body: "mujoco.MjsBody", kind: int, name: str, axis: list[int], stiffness: float, damping: float
) -> "mujoco.MjsJoint":
    """Add a joint with a spring and a damper."""
    joint = body.add_joint()
    joint.name, joint.type, joint.axis = name, kind, axis
    joint.stiffness[0], joint.damping[0] = stiffness, damping
    return joint


def _add_foot(
    spec: "mujoco.MjSpec", parent: "mujoco.MjsBody", plant: PlantParameters, leg: int
) -> None:
    foot = _part(parent, f"foot_{leg}", plant.foot_mass, [TOKEN_INERTIA] * 3)
    foot.pos = plant.shaft_position[leg]
    stiffness, damping = plant.side_stiffness[leg], side_damping(plant)[leg]
    _sprung(foot, SLIDE, f"x_{leg}", [1, 0, 0], stiffness[0], damping[0])
    _sprung(foot, SLIDE, f"y_{leg}", [0, 1, 0], stiffness[1], damping[1])
    _sprung(foot, SLIDE, f"z_{leg}", [0, 0, 1], plant.stiffness[leg], plant.damping[leg])
    turning = float(plant.turning_radius[leg])
    radius = turning if turning > 0 else plant.foot_radius
    if turning > 0:
        roll = _sprung(foot, HINGE, f"roll_{leg}", [0, 1, 0], *ROLLING)
        roll.pos, roll.armature = [0, 0, radius], ROLL_INERTIA
    carrier = foot
    if np.isfinite(plant.ground.stiffness[leg]):
        carrier = _part(foot, f"pad_{leg}", PAD_MASS, [TOKEN_INERTIA] * 3)
        give = plant.ground.stiffness[leg]
        critical = 2 * np.sqrt(give * PAD_MASS)
        _sprung(carrier, SLIDE, f"pad_{leg}", [0, 0, 1], give, PAD_DAMPING_RATIO * critical)
    sole = carrier.add_geom()
    sole.name, sole.type = f"foot_{leg}", mujoco.mjtGeom.mjGEOM_SPHERE
    # its lowest point is the foot
    sole.size, sole.pos, sole.mass, sole.condim = [radius, 0, 0], [0, 0, radius], 0.0, 3
    _touch(sole, plant, float(plant.mu[leg]))
    sole.contype, sole.conaffinity = 0, 1
