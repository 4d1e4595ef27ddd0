"""The MuJoCo model of the robot.

A free torso. Per leg a shaft joint that carries the reflected inertia of the geared motor, a carriage
that slides along x and z of the torso and is tied to the shaft by two joint equalities, and a foot on a
vertical spring below the carriage. The equalities carry the tangent of the exact four-bar at the present
shaft angle, written anew each step (``sim_hw.plant``): so the loop closure holds exactly where the
linkage stands, and the foot's forces act back on the shaft inside MuJoCo's implicit solver.
"""

import mujoco
import numpy as np

from sim_hw.four_bar import foot_path
from sim_hw.plant_parameters import PlantParameters

# Rotary inertia of the carriage and the foot, and the shaft's own mass, which its armature dwarfs:
# MuJoCo needs some for every moving body.
TOKEN_MASS = 0.001
TOKEN_INERTIA = 1e-7
# Nearly rigid ground contact and loop closure: time constant two steps, the least MuJoCo allows.
CONTACT_SOLREF = (0.002, 1.0)
CONTACT_SOLIMP = (0.99, 0.999, 0.0005, 0.5, 2.0)
CLOSURE_SOLREF = (0.002, 1.0)
CLOSURE_SOLIMP = (0.999, 0.9999, 0.0001, 0.5, 2.0)
# Sticking friction creeps in MuJoCo, less so the larger this is; a no-slip pass adds nothing then.
IMPRATIO = 200.0


def build_model(plant: PlantParameters) -> mujoco.MjModel:
    """Compile the model. Joints of leg k: shaft_k, x_k, z_k, spring_k; geom foot_k."""
    spec = mujoco.MjSpec()
    spec.option.timestep = plant.time_step_s / plant.substeps
    spec.option.gravity = [0.0, 0.0, -plant.gravity]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO
    ground = spec.worldbody.add_geom()
    ground.name = "ground"
    ground.type = mujoco.mjtGeom.mjGEOM_PLANE
    ground.size = [0.0, 0.0, 1.0]
    ground.friction = [1e-6, 0.0, 0.0]  # MuJoCo takes the larger of two: the feet decide
    ground.solref, ground.solimp = CONTACT_SOLREF, CONTACT_SOLIMP
    torso = spec.worldbody.add_body()
    torso.name = "torso"
    _shape_torso(torso, plant)
    for leg in range(plant.legs):
        _add_leg(spec, torso, plant, leg)
    return spec.compile()


def _shape_torso(torso: "mujoco.MjsBody", plant: PlantParameters) -> None:
    """Torso with what is left of mass and inertia once the legs at mid-stance are taken off."""
    free = torso.add_freejoint()
    free.name = "free"
    x, z, _, _ = foot_path(plant, np.zeros(plant.legs))
    feet = plant.shaft_position + np.stack([x, np.zeros(plant.legs), z], axis=1)
    parts = [(foot, plant.foot_mass + plant.carriage_mass) for foot in feet]
    parts += [(shaft, TOKEN_MASS) for shaft in plant.shaft_position]
    mass = plant.mass - sum(weight for _, weight in parts)
    centre = -sum(weight * point for point, weight in parts) / mass
    inertia = np.diag(plant.inertia).astype(float)
    for point, weight in [*parts, (centre, mass)]:
        inertia -= weight * (point @ point * np.eye(3) - np.outer(point, point))
    torso.mass = mass
    torso.ipos = centre
    torso.fullinertia = [
        inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2],
    ]  # fmt: skip
    torso.explicitinertial = True
    half = np.abs(plant.shaft_position[:, :2]).max(axis=0)
    belly = torso.add_geom()
    belly.name = "belly"
    belly.type = mujoco.mjtGeom.mjGEOM_BOX
    belly.size = [half[0], half[1] * 0.8, plant.clearance]
    belly.mass = 0.0
    belly.friction = [float(plant.mu.mean()), 0.0, 0.0]
    belly.solref, belly.solimp = CONTACT_SOLREF, CONTACT_SOLIMP
    belly.contype, belly.conaffinity = 0, 1


def _add_leg(
    spec: "mujoco.MjSpec", torso: "mujoco.MjsBody", plant: PlantParameters, leg: int
) -> None:
    shaft = torso.add_body()
    shaft.name, shaft.pos = f"shaft_{leg}", plant.shaft_position[leg]
    shaft.mass, shaft.inertia = TOKEN_MASS, [TOKEN_INERTIA] * 3
    shaft.ipos, shaft.explicitinertial = [0, 0, 0], True
    turn = shaft.add_joint()
    turn.name, turn.type, turn.axis = f"shaft_{leg}", mujoco.mjtJoint.mjJNT_HINGE, [0, 1, 0]
    turn.armature = plant.motor.armature
    turn.solref_friction, turn.solimp_friction = CLOSURE_SOLREF, CLOSURE_SOLIMP
    carriage = torso.add_body()
    carriage.name, carriage.pos = f"carriage_{leg}", plant.shaft_position[leg]
    carriage.mass, carriage.inertia = plant.carriage_mass, [TOKEN_INERTIA] * 3
    carriage.ipos, carriage.explicitinertial = [0, 0, 0], True
    for axis, direction in (("x", [1, 0, 0]), ("z", [0, 0, 1])):
        slide = carriage.add_joint()
        slide.name, slide.type = f"{axis}_{leg}", mujoco.mjtJoint.mjJNT_SLIDE
        slide.axis = direction
        closure = spec.add_equality()
        closure.name, closure.type = f"{axis}_{leg}", mujoco.mjtEq.mjEQ_JOINT
        closure.name1, closure.name2 = f"{axis}_{leg}", f"shaft_{leg}"
        closure.objtype = mujoco.mjtObj.mjOBJ_JOINT
        closure.solref, closure.solimp = CLOSURE_SOLREF, CLOSURE_SOLIMP
    foot = carriage.add_body()
    foot.name, foot.mass, foot.inertia = f"foot_{leg}", plant.foot_mass, [TOKEN_INERTIA] * 3
    foot.ipos, foot.explicitinertial = [0, 0, 0], True
    spring = foot.add_joint()
    spring.name, spring.type, spring.axis = f"spring_{leg}", mujoco.mjtJoint.mjJNT_SLIDE, [0, 0, 1]
    spring.stiffness[0] = plant.stiffness[leg]
    spring.damping[0] = plant.damping[leg]
    sole = foot.add_geom()
    sole.name, sole.type = f"foot_{leg}", mujoco.mjtGeom.mjGEOM_SPHERE
    sole.size = [plant.foot_radius, 0, 0]
    sole.pos = [0, 0, plant.foot_radius]  # its lowest point is the foot
    sole.mass = 0.0
    sole.friction = [plant.mu[leg], 0.0, 0.0]
    sole.condim = 3
    sole.solref, sole.solimp = CONTACT_SOLREF, CONTACT_SOLIMP
    sole.contype, sole.conaffinity = 0, 1
