"""Arrays of a log that are no samples, such as the gains of its joints, kept with the trial by joint."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from model.values.arrays import FloatArray
from record.trial.column_map import Source
from record.trial.header import TrialHeader
from record.trial.table_check import TableFinding
from record.trial.trial import trial_places

_INDEX = re.compile(r".*\[(\d+)\]")


def with_constants(
    header: TrialHeader,
    arrays: Mapping[str, FloatArray],
    sources: Sequence[Source],
    findings: list[TableFinding],
    mapped: Collection[str] = (),
) -> TrialHeader:
    """Return a header with the arrays that have one number a joint, in the order of its joints.

    Args:
        header: The header; what it has already stays.
        arrays: Arrays of the log by name, each of another length than its samples.
        sources: Which columns are which: ``command[3]`` says whose the fourth number is.
        findings: What was taken is listed here, in place of its being ignored.
        mapped: Constants of the header that the map took from arrays, in their order.
    """
    order = _order(header, sources)
    constants = dict(header.constants)
    for name in mapped:
        if len(constants[name]) == len(order):
            constants[name] = tuple(constants[name][at] for at in order)
    for name, values in arrays.items():
        if len(values) not in {1, len(header.joints)} or not header.joints:
            continue
        if name not in constants:
            own = values[order] if len(values) > 1 else values
            constants[name] = tuple(map(float, own))
        words = "one number a joint" if len(values) > 1 else "one number"
        findings[:] = [one for one in findings if (one.kind, one.column) != ("ignored", name)]
        findings.append(
            TableFinding("constant", name, len(values), 0, f"{words}, kept with the trial")
        )
    return replace(header, constants=tuple(constants.items()))


def _order(header: TrialHeader, sources: Sequence[Source]) -> list[int]:
    """Return which number of an array is whose, in the order of the joints: by the columns' own numbers."""
    joint_of = {place.column: place.joint for place in trial_places(header.names)}
    column_of: dict[str, int] = {}
    for one in sources:
        number = _INDEX.fullmatch(one.theirs)
        if number and one.ours in joint_of:
            column_of.setdefault(joint_of[one.ours], int(number[1]))
    own = [column_of.get(joint, at) for at, joint in enumerate(header.joints)]
    return own if sorted(own) == list(range(len(own))) else list(range(len(own)))
