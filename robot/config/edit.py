"""A robot file's text with some numbers changed: comments, order and spelling of all else survive."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from model.effects.catalogue import EFFECTS
from model.effects.causes import Cause
from model.effects.correction import Correction, KeyChange, merged
from model.effects.leg_kinds import check_effects
from model.effects.machine import parse_machine
from model.effects.machine_scale import USUAL_SIZE, size_of
from model.effects.written import EFFECTS_KEY, WHOLE_ROBOT, causes_of
from model.errors import ConfigError, GapError
from model.parameters.tables import (
    LEG_TABLE,
    leg_table,
    parse_table,
    read_body,
    read_leg,
    read_leg_names,
    read_legs,
)
from model.values.machine_names import MachineNames
from model.values.parameters import ChainParameters
from record.toml_file import toml_text
from robot.config.robot_file import parse_robot

DIGITS = 10


@dataclass(frozen=True, slots=True)
class Edit:
    """One number that was changed.

    Attributes:
        key: Its dotted name, with the leg where it has one.
        before: What it was.
        after: What it is.
        why: Effect and place.
    """

    key: str
    before: float
    after: float
    why: str


@dataclass(frozen=True, slots=True)
class Edited:
    """A robot file after a correction.

    Attributes:
        text: The file.
        edits: Numbers of keys that it had.
        effects: Entries of its table of effects that are new or changed.
    """

    text: str
    edits: tuple[Edit, ...]
    effects: tuple[Cause, ...]


def edit_robot(text: str, correction: Correction, origin: str) -> Edited:
    """Write a correction into a robot file.

    Args:
        text: The robot file.
        correction: What is to be done.
        origin: Where it comes from, for a comment at the end.

    Raises:
        ConfigError: A key that is to be changed is not there, or the file is no TOML.
        GapError: An effect that is there already cannot grow, or such legs cannot have it.
    """
    top = parse_table(text)
    legs = read_leg_names(top.table("legs"))
    leg = read_leg(top) if top.has(leg_table(top.names())) else None
    joints = leg.joints if isinstance(leg, ChainParameters) else legs
    size = USUAL_SIZE
    if leg is not None and top.has("body"):
        size = size_of(read_body(top.table("body")).mass, read_legs(top.table("legs"), leg), leg)
    there = causes_of(top, MachineNames(joints, legs), size)
    if leg is not None:
        changes = (change.cause for change in correction.changes)
        check_effects((*changes, *correction.effects), leg)
    document = _document(text)
    edits = tuple(_change(document, change, legs) for change in correction.changes)
    old = {(one.effect, one.joints) for one in there}
    effects = tuple(one for one in merged(there, correction.effects) if one not in there)
    fresh = []
    for one in effects:
        if (one.effect, one.joints) in old:
            document[EFFECTS_KEY][one.effect][_place(one)].update(_numbers(one))
        else:
            fresh.append(one)
    notes = [f"# changed by bigant gap apply, from {origin}:"]
    notes += [
        f"#   {edit.key}: {edit.before:.6g} -> {edit.after:.6g} ({edit.why})" for edit in edits
    ]
    lines = [*(notes if edits else []), *_tables(fresh, origin)]
    body = tomlkit.dumps(document).rstrip("\n")
    return Edited("\n".join([body, "", *lines]).rstrip("\n") + "\n", edits, effects)


def with_servo_zeros(text: str, zeros: Sequence[int]) -> str:
    """Return a robot file's text with other shaft zeros in its ``[legs]``.

    Args:
        text: The robot file.
        zeros: Ticks at shaft angle 0, a leg each.

    Raises:
        ConfigError: The file is no TOML, or has not one zero a leg.
    """
    document = _document(text)
    try:
        there = document["legs"]["servo_zero"]
        if len(there) != len(zeros):
            raise IndexError
        for leg, zero in enumerate(zeros):
            there[leg] = int(zero)
    except (KeyError, IndexError, TypeError) as error:
        raise ConfigError("legs.servo_zero", f"must be a list of {len(zeros)} zeros") from error
    return tomlkit.dumps(document)


def with_estimator(text: str, values: Mapping[str, float | str]) -> str:
    """Return a robot file's text with some keys of its table ``[estimator]`` set; it need not have one.

    Args:
        text: The robot file.
        values: Keys and values.

    Raises:
        ConfigError: The file is no TOML.
    """
    document = _document(text)
    document.setdefault("estimator", tomlkit.table()).update(values)
    return tomlkit.dumps(document)


def _document(text: str) -> Any:  # tables and values are indexed alike
    try:
        return tomlkit.parse(text)
    except TOMLKitError as error:
        raise ConfigError("robot file", f"is not valid TOML: {error}") from error


def _change(document: Any, change: KeyChange, legs: Sequence[str]) -> Edit:
    table = leg_table(document) if change.table == LEG_TABLE else change.table
    where = f"{table}.{change.key}"
    try:
        holder: Any = document[table]
        at: str | int = change.key
        for index in change.index:
            holder, at = holder[at], index
        before = float(holder[at])
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ConfigError(
            where, "is not in the robot file as it should be; see config/bigant.toml"
        ) from error
    after = _short(change.factor * before + change.plus)
    holder[at] = after
    name = where + "".join(
        f"[{legs[index] if i == 0 else 'xyz'[index]}]" for i, index in enumerate(change.index)
    )
    place = f" at {', '.join(change.cause.joints)}" if change.cause.joints else ""
    return Edit(name, before, after, f"{change.cause.effect}{place}")


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _place(cause: Cause) -> str:
    return cause.joints[0] if cause.joints else WHOLE_ROBOT


def _numbers(cause: Cause) -> dict[str, float]:
    named = EFFECTS[cause.effect].named(cause.values)
    return {name: _short(value) for name, value in named.items()}


def _tables(effects: Sequence[Cause], origin: str) -> list[str]:
    if not effects:
        return []
    head = f"What the nominal robot lacks, from {origin}. Delete a table once its cause is fixed."
    table: dict[str, Any] = {}
    for one in effects:
        table.setdefault(one.effect, {})[_place(one)] = _numbers(one)
    return ["", toml_text({EFFECTS_KEY: table}, [head])]


def check_edited(text: str, original: str) -> None:
    """Refuse a corrected file that no command could read.

    Raises:
        ConfigError: A number became impossible.
        GapError: The same, of its physical tables.
    """
    try:
        parse_machine(text)
    except GapError as error:
        raise GapError(f"the corrected robot file would be impossible: {error}") from error
    try:
        parse_robot(original)
    except ConfigError:
        return  # physics only, no robot to drive: that is how it came
    parse_robot(text)
