"""Causes written into a model's file: what MuJoCo has a number for becomes that number, by ``MjSpec``."""

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from gap.machines.mujoco.edited_model import change_body, turned_gravity
from gap.machines.mujoco.effect_table import BODY, MjcfEffect
from gap.machines.mujoco.rigid_model import (
    ModelFile,
    match_joints,
    mistakes_of,
    read_spec,
    strip_shapes,
)
from gap.machines.mujoco.settings import BodyNumbers, WorldNumbers, moved
from model.effects.causes import Cause, Effect, joint_by_joint
from model.errors import GapError

# Numbers of a joint that its file can hold.
IN_JOINT = frozenset({"coulomb_nm", "viscous_nm_s", "armature_kg_m2"})
IN_WORLD = frozenset({"roll_rad", "pitch_rad", "contact_friction"})


def in_model(effect: MjcfEffect) -> bool:
    """Whether an effect is one of the model, and not of its drive or of the log."""
    places = {place for place, _ in effect.places}
    return effect.acts_on == BODY or places <= IN_JOINT or places <= IN_WORLD


def corrected_text(text: str, causes: Sequence[Cause], effects: Sequence[Effect]) -> str:
    """Return an MJCF with causes in it: friction, armature, masses, gravity, contact.

    What is of the drive or of the log is listed in a comment at its head. A URDF becomes an MJCF, because
    only that has frictionloss and armature.

    Args:
        text: MJCF or URDF.
        causes: Of the catalogue.
        effects: The catalogue.

    Raises:
        GapError: No cause is of the model, or the file does not have what one touches.
    """
    known, written, left = _parted(causes, effects)
    if not written:
        raise GapError(
            f"{', '.join(left)} acts on the drive or on the log, not on the bodies, so no number of the "
            "model can hold it: change it in [drive] beside the log, or in the controller"
        )
    spec, notes = (
        read_spec(ModelFile(text)),
        [f"of the drive or the log: {', '.join(left)}"] * bool(left),
    )
    try:
        model = spec.compile()
    except ValueError:  # files of shapes lie where this text is not
        spec = read_spec(ModelFile(text))
        strip_shapes(spec)
        notes.append("shapes whose files are not here")
        with mistakes_of("the model"):
            model = spec.compile()
    for cause in written:
        _write(spec, model, cause, known[cause.effect])
    spec.compile()
    note = f"<!-- not written: {'; '.join(notes)} -->\n" if notes else ""
    return note + str(spec.to_xml())


def left_by_text(causes: Sequence[Cause], effects: Sequence[Effect]) -> tuple[str, ...]:
    """Return the effects among some causes that no number of a model can hold; arguments as above."""
    return _parted(causes, effects)[2]


def _parted(
    causes: Sequence[Cause], effects: Sequence[Effect]
) -> tuple[Mapping[str, MjcfEffect], list[Cause], tuple[str, ...]]:
    """Return the catalogue by name, causes of the model, joint by joint, and the effects of all others."""
    known = {one.name: one for one in effects if isinstance(one, MjcfEffect)}
    single = [one for cause in causes for one in joint_by_joint(cause, known[cause.effect])]
    written = [one for one in single if in_model(known[one.effect])]
    left = {one.effect for one in single if not in_model(known[one.effect])}
    return known, written, tuple(sorted(left))


def _write(spec: Any, model: Any, cause: Cause, effect: MjcfEffect) -> None:
    pairs = tuple(zip(effect.places, cause.values, strict=True))
    if effect.acts_on == BODY:
        for name in cause.joints:
            _write_body(spec, model, name, moved(BodyNumbers(), pairs))
        return
    values = {place: value for (place, _), value in pairs}
    if values.keys() <= IN_WORLD:
        world = moved(WorldNumbers(), pairs)
        spec.option.gravity = turned_gravity(np.asarray(spec.option.gravity), world)
        for geom in spec.geoms:
            geom.friction = np.asarray(geom.friction) * world.contact_friction
        return
    for name in match_joints(spec, cause.joints, {}, "the model"):
        joint = spec.joint(name)
        joint.frictionloss += values.get("coulomb_nm", 0.0)
        damping = np.array(joint.damping)
        damping[0] += values.get("viscous_nm_s", 0.0)
        joint.damping = damping
        joint.armature += values.get("armature_kg_m2", 0.0)


def _write_body(spec: Any, model: Any, name: str, numbers: BodyNumbers) -> None:
    """Write a body's mass, centre and inertia as its own numbers, whatever they were made from."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    if number < 0:
        raise GapError(
            f"the model has no body {name!r}, so its mass cannot be written; name it there"
        )
    change_body(model, number, numbers, 2.0 * model.body_ipos[number])
    body = spec.body(name)
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    body.explicitinertial = True
    body.mass, body.ipos = float(model.body_mass[number]), model.body_ipos[number]
    body.iquat, body.inertia = model.body_iquat[number], model.body_inertia[number]
    body.fullinertia = np.full(6, np.nan)
