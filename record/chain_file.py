"""Legs of several joints from an MJCF or URDF: MuJoCo reads it once, and the robot file keeps numbers.

A robot file with ``kind = "chain"`` in [leg] names the file::

    [leg]
    kind = "chain"
    model = "hexapod18.xml"          # beside the robot file
    feet = ["LF_foot", "LM_foot"]    # site, body (link) or geom, one a leg in the order of legs.order
    body = "torso"                   # what the legs hang on; without it the body with the free joint
    origin = [0.0, 0.0, 0.0]         # centre of mass in that body; the body frame begins there
    joints = ["LF_coxa", "LF_femur"] # order of the joints in tables; without it leg by leg, foot last
    sign = [1, 1]                    # joint of the file = zero + sign * ours, one a joint
    zero = [0.0, 0.0]
    radius = [0.0, 0.0]              # of feet that are balls; without it those of spheres in the file

``complete`` appends the table [leg.chain] (``model.parameters.chain_table``) to its text. Meshes, motors
and whatever else has no bearing on the feet is not opened.
"""

import warnings
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from model.errors import ConfigError
from model.parameters.chain_table import chain_lines
from model.parameters.tables import CHAIN
from model.parameters.toml_table import Table, parse_toml
from model.values.arrays import FloatArray
from model.values.parameters import ChainParameters
from record.input_file import read_utf8

# Of an MJCF or URDF, what kinematics do without; its files may be missing.
BESIDE = (
    "keys", "actuators", "sensors", "equalities", "tendons", "pairs", "excludes", "tuples", "skins",
    "flexes", "meshes", "hfields", "materials", "textures",
)  # fmt: skip
LEAST_MASS_KG, LEAST_INERTIA = 1e-6, 1e-9  # of bodies that had theirs from a mesh


@dataclass(frozen=True, slots=True)
class ChainNames:
    """What a robot file says of its legs' file, by name; lists may be empty where they may be left out."""

    feet: tuple[str, ...]
    body: str
    joints: tuple[str, ...]
    origin: tuple[float, ...]
    legs: tuple[str, ...]


def complete(text: str, folder: Path) -> str:
    """Return a robot file's text with the numbers of its legs in it; as it is where it needs none.

    Args:
        text: The robot file.
        folder: Where it lies.

    Raises:
        ConfigError: The file of the legs cannot be read, or has not what the robot file names.
    """
    if CHAIN not in text:
        return text
    leg = parse_toml(text, "robot file").get("leg")
    if not isinstance(leg, dict) or leg.get("kind") != CHAIN or CHAIN in leg:
        return text
    table, order = Table(leg, "leg"), parse_toml(text, "robot file").get("legs")
    names = ChainNames(
        feet=table.texts("feet"),
        body=table.maybe_text("body"),
        joints=table.texts("joints") if table.has("joints") else (),
        origin=tuple(table.numbers("origin", (3,)).tolist()) if table.has("origin") else (0,) * 3,
        legs=Table(order if isinstance(order, dict) else {}, "legs").texts("order"),
    )
    chain = _with_encoders(read_chain_file(folder / table.text("model"), names), table)
    whole = "\n".join([text.rstrip("\n"), "", *chain_lines(chain, table.text("model")), ""])
    try:
        parse_toml(whole, "robot file")
    except ConfigError as error:
        raise ConfigError("leg", "write it as a table of its own, [leg], one key a line") from error
    return whole


def _with_encoders(chain: ChainParameters, table: Table) -> ChainParameters:
    """Signs and zeros of what a table's angles mean in the file's joints, and radii that are given."""
    count = chain.count
    sign, zero, radius = chain.sign, chain.zero, chain.radius
    if table.has("sign"):
        sign = table.integers("sign", count, minimum=-1, maximum=1).astype(np.float64)
    if table.has("zero"):
        zero = zero + table.numbers("zero", (count,))
    if table.has("radius"):
        radius = table.numbers("radius", (len(radius),))
    return ChainParameters(
        chain.joints, chain.parent, chain.slides, chain.axis, chain.place, sign, zero,
        chain.foot_joint, chain.foot, radius,
    )  # fmt: skip


def read_chain_file(path: Path, names: ChainNames) -> ChainParameters:
    """Read legs from an MJCF or URDF.

    Args:
        path: The file.
        names: What in it are the legs.

    Raises:
        ConfigError: The file cannot be read, or has not what is named.
    """
    if len(names.feet) != len(names.legs):
        words = f"names {len(names.feet)} feet for {len(names.legs)} legs; name one a leg"
        raise ConfigError("leg.feet", words)
    return _FileModel(path, names).chain()


def _compiled(path: Path) -> Any:
    """MuJoCo's model of the bodies and joints of a file."""
    import mujoco  # here: nothing else that reads a robot file needs a simulator

    try:
        read_utf8(path)
        spec = mujoco.MjSpec.from_file(str(path))
        shapes = mujoco.mjtGeom
        with_files = (shapes.mjGEOM_MESH, shapes.mjGEOM_HFIELD, shapes.mjGEOM_SDF)
        for geom in [one for one in spec.geoms if one.type in with_files]:
            spec.delete(geom)
        for kind in BESIDE:
            for one in list(getattr(spec, kind)):
                spec.delete(one)
        spec.compiler.fusestatic = False  # a link that is fixed may be a foot
        spec.compiler.boundmass, spec.compiler.boundinertia = LEAST_MASS_KG, LEAST_INERTIA
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of inertias, which kinematics do without
            return spec.compile()
    except OSError as error:
        raise ConfigError("leg.model", f"{path} cannot be read: {error.strerror}") from error
    except ValueError as error:  # MuJoCo's own words
        first = " ".join(str(error).split())
        raise ConfigError("leg.model", f"{path} is no MJCF or URDF for MuJoCo: {first}") from error


class _FileModel:
    """A file's model at its drawn pose, and what a robot file names in it."""

    def __init__(self, path: Path, names: ChainNames) -> None:
        import mujoco

        self._path, self._names, self._mujoco = path, names, mujoco
        self._model = _compiled(path)
        self._data = mujoco.MjData(self._model)
        mujoco.mj_kinematics(self._model, self._data)
        self._body = self._carrier()

    def chain(self) -> ChainParameters:
        """Return the legs in the frame of the body that carries them."""
        paths = [self._joints_to(leg) for leg in range(len(self._names.legs))]
        order = self._order(list(dict.fromkeys(joint for path in paths for joint in path)))
        rows = {joint: row for row, joint in enumerate(order)}
        parent = np.full(len(order), -1, dtype=np.int64)
        for path in paths:
            for above, joint in pairwise(path):
                parent[rows[joint]] = rows[above]
        for row, joint in enumerate(order):
            if parent[row] >= row:
                words = f"{self._joint_name(joint)} comes before the joint that carries it"
                raise ConfigError("leg.joints", f"{words}; list that one first")
        data, hinge = self._data, int(self._mujoco.mjtJoint.mjJNT_HINGE)
        address = self._model.jnt_qposadr[order]
        return ChainParameters(
            joints=tuple(map(self._joint_name, order)),
            parent=parent,
            slides=np.asarray(self._model.jnt_type[order] != hinge),
            axis=self._in_body(data.xaxis[order]),
            place=self._in_body(data.xanchor[order] - self._origin()),
            sign=np.ones(len(order)),
            zero=0.0 - self._model.qpos0[address],
            foot_joint=np.array([rows[path[-1]] for path in paths], dtype=np.int64),
            foot=self._in_body(np.array([self._foot(n)[1] for n in self._names.feet]) - self._origin()),
            radius=np.array([self._ball(name) for name in self._names.feet]),
        )  # fmt: skip

    def _in_body(self, vectors: FloatArray) -> FloatArray:
        turned: FloatArray = vectors @ self._data.xmat[self._body].reshape(3, 3)
        return turned

    def _origin(self) -> FloatArray:
        turn = self._data.xmat[self._body].reshape(3, 3)
        place: FloatArray = self._data.xpos[self._body] + turn @ np.array(self._names.origin)
        return place

    def _carrier(self) -> int:
        """The body on which the legs hang."""
        model, name = self._model, self._names.body
        if name:
            body = self._id(self._mujoco.mjtObj.mjOBJ_BODY, name)
            if body < 0:
                raise ConfigError("leg.body", f"{self._path} has no body {name!r}{self._bodies()}")
            return body
        free = model.jnt_bodyid[model.jnt_type == int(self._mujoco.mjtJoint.mjJNT_FREE)].tolist()
        roots = free or [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
        if len(roots) != 1:
            words = f"is missing, and {self._path} has {len(roots)} bodies that could be it"
            raise ConfigError("leg.body", f"{words}; name the one that the legs hang on")
        return int(roots[0])

    def _bodies(self) -> str:
        names = ", ".join(self._model.body(body).name for body in range(1, self._model.nbody))
        return f"; there are {names}"

    def _id(self, kind: Any, name: str) -> int:
        return int(self._mujoco.mj_name2id(self._model, kind, name))

    def _foot(self, name: str) -> tuple[int, FloatArray]:
        """Body and place in the world of what is named as a foot."""
        kinds, model, data = self._mujoco.mjtObj, self._model, self._data
        if (site := self._id(kinds.mjOBJ_SITE, name)) >= 0:
            return int(model.site_bodyid[site]), data.site_xpos[site].copy()
        if (geom := self._id(kinds.mjOBJ_GEOM, name)) >= 0:
            return int(model.geom_bodyid[geom]), data.geom_xpos[geom].copy()
        if (body := self._id(kinds.mjOBJ_BODY, name)) >= 0:
            return body, data.xpos[body].copy()
        words = f"{self._path} has no site, geom or body {name!r} (meshes are not opened)"
        raise ConfigError("leg.feet", f"{words}{self._bodies()}")

    def _ball(self, name: str) -> float:
        """Radius of a foot that is a sphere, 0 of anything else."""
        kinds, geom = self._mujoco.mjtObj, self._id(self._mujoco.mjtObj.mjOBJ_GEOM, name)
        site = self._id(kinds.mjOBJ_SITE, name)
        sphere = int(self._mujoco.mjtGeom.mjGEOM_SPHERE)
        if site >= 0 or geom < 0 or self._model.geom_type[geom] != sphere:
            return 0.0
        return float(self._model.geom_size[geom, 0])

    def _joints_to(self, leg: int) -> list[int]:
        """Joints between the body and a leg's foot, from the body on."""
        model, names, joints = self._model, self._names, list[int]()
        body, _ = self._foot(names.feet[leg])
        while body != self._body:
            if body == 0:
                words = f"{names.feet[leg]} does not hang on {model.body(self._body).name}"
                raise ConfigError("leg.feet", f"{words}; name the body that carries the legs")
            first, count = model.body_jntadr[body], model.body_jntnum[body]
            joints += range(first + count - 1, first - 1, -1)
            body = int(model.body_parentid[body])
        kinds = self._mujoco.mjtJoint
        for joint in joints:
            if model.jnt_type[joint] not in [int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)]:
                words = f"joint {self._joint_name(joint)!r} of leg {names.legs[leg]} neither turns about"
                raise ConfigError("leg.model", f"{words} one axis nor slides along one")
            if not model.joint(joint).name:
                words = f"a joint of leg {names.legs[leg]} has no name; name it in {self._path}"
                raise ConfigError("leg.model", words)
        if not joints:
            words = f"no joint is between {names.feet[leg]} and {model.body(self._body).name}"
            raise ConfigError("leg.feet", f"{words}; name a point that the leg moves")
        return list(reversed(joints))

    def _joint_name(self, joint: int) -> str:
        return str(self._model.joint(joint).name)

    def _order(self, joints: list[int]) -> list[int]:
        """The joints in the order of the robot file, if it gives one."""
        if not self._names.joints:
            return joints
        names = {self._joint_name(joint): joint for joint in joints}
        for name in self._names.joints:
            if name not in names:
                words = f"{name!r} moves no foot; between body and feet are {', '.join(names)}"
                raise ConfigError("leg.joints", words)
        missing = names.keys() - set(self._names.joints)
        if missing:
            words = f"is without {', '.join(sorted(missing))}, which move feet; name all"
            raise ConfigError("leg.joints", words)
        return [names[name] for name in self._names.joints]
