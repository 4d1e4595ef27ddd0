"""An MJCF or URDF as the rigid bodies of a machine: read, stripped to what is compared, compiled.

The joints of a log are looked for by name. Joints that no log names are welded where they are at zero,
actuators go (the log's drive takes their place), and geometry stays only where it touches something or
gives a body its mass.
"""

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from model.errors import GapError
from model.values.arrays import FloatArray, IntArray

SUFFIX = "_joint"  # of joints of many files, that a log leaves out
TOUCHES, FLOATS = "contact", "base"
MESHES = (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD, mujoco.mjtGeom.mjGEOM_SDF)
HANGING = ("actuators", "sensors", "keys", "cameras", "lights", "textures", "materials", "skins")


@dataclass(frozen=True, slots=True)
class ModelFile:
    """The text of an MJCF or URDF, and the folder in which its meshes and includes lie."""

    text: str
    name: str = "robot.xml"
    folder: str = ""


@dataclass(frozen=True, slots=True)
class Mounting:
    """How the bodies stand in the world.

    Attributes:
        base: ``fixed``, ``free``, or empty for what the file says.
        contact: Whether bodies touch each other and the ground.
        names: Joints of the file by the log's names, where they cannot be guessed.
    """

    base: str = ""
    contact: bool = False
    names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class RigidModel:
    """A compiled model, and where the joints of the log lie in it.

    Attributes:
        model: MuJoCo's model; copied before anything in it is changed.
        joints: Names in the log, J of them.
        in_file: Names in the file, J.
        position: Where their positions are among ``qpos``, (J,).
        speed: Where their speeds are among ``qvel``, (J,).
        bodies: Names of bodies that move and weigh, B of them.
        body: Their numbers in the model, (B,).
        joint_tree: Group of each joint, (J,): bodies of one group do not act on those of another.
        body_tree: Group of each body, (B,); -1 for one that none of the joints moves.
        welded: Joints of the file that no log names.
        limit_nm: Torque limit of each joint by the file, (J,); infinite without.
        floating: Whether the base is free.
        lean: The same without actuators and with bodies in one that no joint parts, which is a sixth less
            to step; None where it might move otherwise.
    """

    model: Any
    joints: tuple[str, ...]
    in_file: tuple[str, ...]
    position: IntArray
    speed: IntArray
    bodies: tuple[str, ...]
    body: IntArray
    joint_tree: IntArray
    body_tree: IntArray
    welded: tuple[str, ...]
    limit_nm: FloatArray
    floating: bool
    contact: bool
    lean: Any = None

    @property
    def trees(self) -> int:
        """How many groups there are."""
        return int(self.joint_tree.max()) + 1

    def data(self) -> Any:
        """Return fresh data of the model."""
        return mujoco.MjData(self.model)


def read_rigid_model(
    file: ModelFile, joints: Sequence[str], mounting: Mounting, *, driven: bool = False
) -> RigidModel:
    """Compile the model of the joints that a log names; driven, each has an actuator, in their order.

    Raises:
        GapError: The file cannot be read or compiled, or has none of a joint's name.
    """
    spec = read_spec(file)
    in_file = match_joints(spec, joints, mounting.names, file.name)
    limit_nm = np.array([_limit(spec, name) for name in in_file])
    welded = _strip(spec, in_file, mounting)
    bare = spec.copy()
    for name in in_file if driven else ():
        loop = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        loop.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    for one in (spec, bare):
        _set_options(one, mounting)
    with mistakes_of(file.name):
        model = spec.compile()
    number = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in in_file]
    moving = [
        one for one in range(1, model.nbody) if model.body_weldid[one] and model.body_mass[one] > 0
    ]
    tree = _trees(model)
    speed = model.jnt_dofadr[number].astype(np.int64)
    return RigidModel(
        model=model,
        joints=tuple(joints),
        in_file=tuple(in_file),
        position=model.jnt_qposadr[number].astype(np.int64),
        speed=speed,
        bodies=tuple(_body_name(model, one) for one in moving),
        body=np.array(moving, dtype=np.int64),
        joint_tree=tree[model.dof_bodyid[speed]],
        body_tree=tree[moving] if moving else np.zeros(0, dtype=np.int64),
        welded=welded,
        limit_nm=limit_nm,
        floating=bool((model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any()),
        contact=mounting.contact,
        lean=_lean(bare, model) if driven and not mounting.contact else None,
    )


def _set_options(spec: Any, mounting: Mounting) -> None:
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # islands cost more than they save in machines of so few joints
    off = mujoco.mjtDisableBit
    spec.option.disableflags |= off.mjDSBL_AUTORESET | off.mjDSBL_ISLAND | off.mjDSBL_SENSOR
    if not mounting.contact:
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        # friction of joints and their limits alone: exact in a sweep or two, and a sixth less to do
        spec.option.solver = mujoco.mjtSolver.mjSOL_PGS


def _lean(bare: Any, model: Any) -> Any:
    """Return the model without actuators and fewer bodies; None where that is not known to be the same."""
    off = mujoco.mjtDisableBit
    passive = int(
        off.mjDSBL_SPRING | off.mjDSBL_DAMPER | off.mjDSBL_ACTUATION | off.mjDSBL_EULERDAMP
    )
    curved = model.jnt_stiffnesspoly.any() or model.dof_dampingpoly.any()
    if model.neq or model.ntendon or curved or model.opt.disableflags & passive:
        return None
    bare.compiler.fusestatic = True
    # all damping is of joints, and that is implicit in this one, too
    bare.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    try:
        return bare.compile()
    except (ValueError, RuntimeError, mujoco.FatalError):
        return None  # something refers to a body that would go


def read_spec(file: ModelFile) -> Any:
    """Return MuJoCo's specification of a file, not yet compiled.

    Raises:
        GapError: It cannot be read.
    """
    path = Path(file.folder) / file.name
    with mistakes_of(file.name):
        if file.folder and path.is_file() and path.read_text(encoding="utf-8") == file.text:
            return mujoco.MjSpec.from_file(str(path))  # finds what it includes
        spec = mujoco.MjSpec.from_string(file.text)
    if file.folder:
        spec.modelfiledir = file.folder
    return spec


def match_joints(
    spec: Any, joints: Sequence[str], names: Mapping[str, str], file: str
) -> list[str]:
    """Return the file's name of each joint of a log: its own, or the same with ``_joint`` behind it.

    Raises:
        GapError: There is none, or it is neither a hinge nor a slide.
    """
    kinds = {joint.name: joint.type for joint in spec.joints}
    hinge_or_slide = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    driven = [name for name, kind in kinds.items() if kind in hinge_or_slide]
    matched = []
    for joint in joints:
        wanted = (names[joint],) if joint in names else (joint, joint + SUFFIX)
        name = next((one for one in wanted if one in driven), "")
        if not name:
            raise GapError(
                f"{file} has no joint {wanted[0]!r}; it has {', '.join(driven) or 'none'}: give the file "
                f'of the robot that was logged, or name its joint: [drive.joint.{joint}] name = "..."'
            )
        matched.append(name)
    twice = {name for name in matched if matched.count(name) > 1}
    if twice:
        raise GapError(
            f"two joints of the log are {', '.join(sorted(twice))} of {file}; name each once"
        )
    return matched


def _limit(spec: Any, joint: str) -> float:
    """Most torque that a file lets the actuators of a joint give."""
    limits = [spec.joint(joint).actfrcrange]
    for one in spec.actuators:
        if one.target == joint:
            direct = one.gainprm[0] == 1.0 and not any(one.biasprm[:3])
            limits += [abs(one.gear[0]) * np.asarray(one.forcerange)]
            limits += [abs(one.gear[0]) * np.asarray(one.ctrlrange)] if direct else []
    given = [float(np.max(np.abs(one))) for one in limits if np.any(one)]
    return min(given, default=math.inf)


def _strip(spec: Any, in_file: Sequence[str], mounting: Mounting) -> tuple[str, ...]:
    """Take off what the comparison has no use for; return the joints that were welded."""
    free = [one for one in spec.joints if one.type == mujoco.mjtJoint.mjJNT_FREE]
    if mounting.base == "fixed":
        for joint in free:
            spec.delete(joint)
    elif mounting.base == "free" and not free:
        roots = [one for one in spec.worldbody.bodies if any(True for _ in _below(one))]
        roots[0].add_freejoint()
    kept = {*in_file}
    welded = []
    for joint in list(spec.joints):
        if joint.type != mujoco.mjtJoint.mjJNT_FREE and joint.name not in kept:
            welded.append(joint.name)
            spec.delete(joint)
    for kind in HANGING:
        for one in list(getattr(spec, kind)):
            spec.delete(one)
    if welded:  # what couples a joint that is gone
        for one in (*spec.equalities, *spec.tendons):
            spec.delete(one)
    if not mounting.contact:
        strip_shapes(spec)
    return tuple(welded)


def strip_shapes(spec: Any) -> None:
    """Take the shapes off that give no body its mass, and the files that they came from."""
    from_shapes = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for body in spec.bodies:
        if from_shapes or (not body.explicitinertial and body.name != "world"):
            continue
        for geom in list(body.geoms):
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms if geom.type in MESHES}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)


def _below(body: Any) -> Any:
    """Yield every joint of a body and of those that it carries."""
    yield from body.joints
    for one in body.bodies:
        yield from _below(one)


def _trees(model: Any) -> IntArray:
    """Group of each body, (nbody,): of one kinematic tree, unless anything couples trees."""
    coupled = (
        model.neq
        or model.ntendon
        or (model.ngeom and not (model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_CONTACT)))
    )
    own = np.asarray(model.body_treeid, dtype=np.int64)
    return np.where(own >= 0, 0, -1) if coupled else own


def _body_name(model: Any, number: int) -> str:
    return str(model.body(number).name) or f"body{number}"


@contextmanager
def mistakes_of(name: str) -> Iterator[None]:
    """Turn whatever MuJoCo says of a file into one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (OSError, UnicodeDecodeError) as error:
        raise GapError(f"{name} cannot be read: {error}") from error
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        first = next((line.strip() for line in str(error).splitlines() if line.strip()), "")
        raise GapError(
            f"{name} is no model that MuJoCo can compile: {first}; fix it (try: python -m mujoco.viewer "
            f"--mjcf={name})"
        ) from error
