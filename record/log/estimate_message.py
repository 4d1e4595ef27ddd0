"""What the estimator says in a tick, as ``bigant_msgs/msg/Estimate`` in the tick's message.

Not by ``record.log.fields``: its fields are in another order than the dataclass's, single numbers are in
one row, and of a covariance only the lower half, row by row, is kept.
"""

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import FloatArray, readonly
from model.values.estimate import Estimate, Health
from record.log.cdr import BOOLS, FLOATS, INTS, CdrReader, CdrWriter
from record.log.fields import KINDS, writer_of
from record.message_form import MessagePart

# planar: x, y, yaw; vx, vy, yaw rate; bias of the same; roll, pitch, height; NIS, log likelihood, age of
# forces
ESTIMATE_TEXT = (
    "uint8 OK=0\nuint8 DEGRADED=1\nuint8 LOST=2\n"
    "int64 t_ns\nuint8 health\nstring reason\nbool holding\nint64 nis_dof\nint64 rejects\n"
    "float64[15] planar\nfloat64[6] pose_covariance\nfloat64[6] twist_covariance\n"
    "float64[] mu\nfloat64[] mu_sd\nfloat64[] stiffness\nfloat64[] stiffness_sd\n"
    "float64[] force_b\nfloat64[] force_covariance\nfloat64[] load_share\n"
    "float64[] load_share_sd\nfloat64[] innovation\nbool[] contact\nbool[] slipping\n"
    "float64 gyro_bias\nfloat64 gyro_bias_sd\n"
    "string remark\nfloat64[] source_nis\nint64[] source_dof\nfloat64[] noise_scale\n"
)
HEALTHS = (Health.OK, Health.DEGRADED, Health.LOST)  # codes 0, 1, 2
# a covariance is symmetric to the last bit: six of its nine numbers are kept
_ROWS, _COLUMNS = np.tril_indices(3)
_LOWER = 3 * _ROWS + _COLUMNS
NOT_KEPT = readonly(np.empty((0, 3)))  # of the estimate: what a log does not hold
NO_NUMBERS, NO_COUNTS = readonly(np.empty(0)), readonly(np.empty(0, dtype=np.int64))


def _lower(covariance: FloatArray) -> tuple[float, ...]:
    """Lower half of one covariance, row by row."""
    (a, _, _), (b, c, _), (d, e, f) = covariance.tolist()
    return a, b, c, d, e, f


SCOPE = {"healths": HEALTHS, "lower_of": _lower, "lower": _LOWER, **KINDS}
_RECORD, _TEXT, _SEQUENCE, _FLAGS = (
    ("record", ""), ("texts", ""), ("sequences", "FLOATS"), ("sequences", "BOOLS"),
)  # fmt: skip
BEFORE_SOURCES = (
    MessagePart(_RECORD, "qB", "value.t_ns, healths.index(value.health)"),
    MessagePart(_TEXT, "", "value.reason"),
    MessagePart(_RECORD, "?qq", "value.holding, value.nis_dof, value.rejects"),
    MessagePart(_RECORD, "ddd", "*value.position_m.tolist(), value.yaw_rad"),
    MessagePart(_RECORD, "dddddd", "*value.velocity_B.tolist(), *value.bias_B.tolist()"),
    MessagePart(_RECORD, "ddd", "*value.tilt_rad.tolist(), value.height_m"),
    MessagePart(_RECORD, "ddd", "value.nis, value.log_likelihood, value.force_age_s"),
    MessagePart(_RECORD, "dddddd", "*lower_of(value.pose_covariance)"),
    MessagePart(_RECORD, "dddddd", "*lower_of(value.twist_covariance)"),
    MessagePart(_SEQUENCE, "", "value.mu"),
    MessagePart(_SEQUENCE, "", "value.mu_sd"),
    MessagePart(_SEQUENCE, "", "value.stiffness"),
    MessagePart(_SEQUENCE, "", "value.stiffness_sd"),
    MessagePart(_SEQUENCE, "", "value.force_B"),
    MessagePart(_SEQUENCE, "", "value.force_covariance.reshape(-1, 9).take(lower, axis=1)"),
    MessagePart(_SEQUENCE, "", "value.load_share"),
    MessagePart(_SEQUENCE, "", "value.load_share_sd"),
    MessagePart(_SEQUENCE, "", "value.innovation"),
    MessagePart(_FLAGS, "", "value.contact"),
    MessagePart(_FLAGS, "", "value.slipping"),
)
SOURCES = (
    MessagePart(_RECORD, "dd", "value.gyro_bias_rad_s, value.gyro_bias_sd"),
    MessagePart(_TEXT, "", "value.remark"),
    MessagePart(_SEQUENCE, "", "value.source_nis"),
    MessagePart(("sequences", "INTS"), "", "value.source_dof"),
    MessagePart(_SEQUENCE, "", "value.noise_scale"),
)
_write_before_sources = writer_of(BEFORE_SOURCES, dict(SCOPE))
_write_sources = writer_of(SOURCES, dict(SCOPE))


def write_estimate(w: CdrWriter, estimate: Estimate | None, *, with_sources: bool = True) -> None:
    """Write an estimate: a sequence of one, or of none; before layout 4 without gyro bias and sources."""
    w.count(estimate is not None)
    if estimate is None:
        return
    _write_before_sources(w, estimate)
    if with_sources:
        _write_sources(w, estimate)


def one_behind_the_other(values: Sequence[Any]) -> NDArray[Any]:
    """Numbers, or arrays of one shape and kind, of many ticks in one row."""
    first = values[0]
    if not (isinstance(first, np.ndarray) and first.ndim):
        return np.array(values)
    try:
        return np.frombuffer(b"".join(values), first.dtype)  # a quarter of the time of numpy's
    except BufferError:  # rows of theirs do not lie one behind the other
        return np.concatenate(values, axis=None)


class EstimateFields(Protocol):
    """Fields of B estimates of one robot, each in all of them at once."""

    def __len__(self) -> int:
        """B."""
        ...

    def column(self, name: str) -> NDArray[Any]:
        """Return a field in numbers, (B, ...); its names are those of ``Estimate``."""
        ...

    def texts(self, name: str) -> list[str]:
        """Return a text of each."""
        ...

    def healths(self) -> list[Health]:
        """Return the verdict in each."""
        ...


class ListedEstimates:
    """Fields of estimates that are there one by one.

    Args:
        estimates: At least one, all of one robot.
    """

    def __init__(self, estimates: Sequence[Estimate]) -> None:
        self._estimates = estimates

    def __len__(self) -> int:
        return len(self._estimates)

    def column(self, name: str) -> NDArray[Any]:
        """As in ``EstimateFields``."""
        values = list(map(attrgetter(name), self._estimates))
        return one_behind_the_other(values).reshape(len(values), *np.shape(values[0]))

    def texts(self, name: str) -> list[str]:
        """As in ``EstimateFields``."""
        return list(map(attrgetter(name), self._estimates))

    def healths(self) -> list[Health]:
        """As in ``EstimateFields``."""
        return [one.health for one in self._estimates]


def estimate_columns(of: EstimateFields) -> Iterator[tuple[str, NDArray[Any] | list[str]]]:
    """Yield the fields of B estimates as ``write_estimate`` writes them, by their names in the message.

    Args:
        of: The estimates.

    Yields:
        Name, and numbers with a row for each estimate, (B, ...), or texts.
    """
    count = len(of)

    def together(name: str) -> NDArray[Any]:
        return of.column(name).reshape(count, -1)

    single = of.column
    yield "t_ns", single("t_ns")
    yield "health", np.array([HEALTHS.index(one) for one in of.healths()])
    yield "reason", of.texts("reason")
    for name in ("holding", "nis_dof", "rejects"):
        yield name, single(name)
    planar = np.empty((count, 15))
    planar[:, 0:2], planar[:, 2] = together("position_m"), single("yaw_rad")
    planar[:, 3:6], planar[:, 6:9] = together("velocity_B"), together("bias_B")
    planar[:, 9:11], planar[:, 11] = together("tilt_rad"), single("height_m")
    planar[:, 12], planar[:, 13] = single("nis"), single("log_likelihood")
    planar[:, 14] = single("force_age_s")
    yield "planar", planar
    for name in ("pose_covariance", "twist_covariance"):
        yield name, together(name)[:, _LOWER]
    for name in ("mu", "mu_sd", "stiffness", "stiffness_sd"):
        yield name, together(name)
    yield "force_b", together("force_B")
    yield "force_covariance", together("force_covariance").reshape(-1, 9)[:, _LOWER]
    for name in ("load_share", "load_share_sd", "innovation", "contact", "slipping"):
        yield name, together(name)
    yield "gyro_bias", single("gyro_bias_rad_s")
    yield "gyro_bias_sd", single("gyro_bias_sd")
    yield "remark", of.texts("remark")
    for name in ("source_nis", "source_dof", "noise_scale"):
        yield name, together(name)


def read_estimate(r: CdrReader, *, with_sources: bool = True) -> Estimate | None:
    """Read an estimate, None if there is none; before layout 4 it had no gyro bias and no sources.

    Raises:
        ValueError: The message is damaged.
    """
    if r.count() == 0:
        return None
    (t_ns, health), (reason,) = r.record("qB"), r.texts(1)
    if health >= len(HEALTHS):
        raise ValueError(f"an estimate's health is 0 to {len(HEALTHS) - 1}, not {health}")
    holding, nis_dof, rejects = r.record("?qq")
    planar, pose_covariance, twist_covariance = r.arrays(FLOATS, 15, 6, 6)
    numbers = planar.tolist()
    mu, mu_sd, stiffness, stiffness_sd = r.sequences(FLOATS, 4)
    force, force_covariance = r.sequence(FLOATS), r.sequence(FLOATS)
    load_share, load_share_sd = r.sequences(FLOATS, 2)
    innovation = r.sequence(FLOATS)
    contact, slipping = r.sequences(BOOLS, 2)
    bias, bias_sd, nis, dof, scale = np.nan, np.nan, NO_NUMBERS, NO_COUNTS, NO_NUMBERS
    remark = ""
    if with_sources:
        bias, bias_sd = r.record("dd")
        (remark,) = r.texts(1)
        nis, dof, scale = r.sequence(FLOATS), r.sequence(INTS), r.sequence(FLOATS)
    return Estimate(
        t_ns=t_ns,
        position_m=planar[0:2],
        yaw_rad=numbers[2],
        velocity_B=planar[3:6],
        pose_covariance=_square(pose_covariance),
        companion_pose=NOT_KEPT,
        twist_covariance=_square(twist_covariance),
        bias_B=planar[6:9],
        mu=mu,
        mu_sd=mu_sd,
        stiffness=stiffness,
        stiffness_sd=stiffness_sd,
        force_B=force.reshape(-1, 3),
        force_covariance=_square(force_covariance.reshape(-1, 6)),
        load_share=load_share,
        load_share_sd=load_share_sd,
        tilt_rad=planar[9:11],
        height_m=numbers[11],
        contact=contact,
        slipping=slipping,
        holding=holding,
        nis=numbers[12],
        nis_dof=nis_dof,
        source_nis=nis,
        source_dof=dof,
        noise_scale=scale,
        log_likelihood=numbers[13],
        innovation=innovation.reshape(-1, 3),
        rejects=rejects,
        force_age_s=numbers[14],
        health=HEALTHS[health],
        reason=reason,
        gyro_bias_rad_s=bias,
        gyro_bias_sd=bias_sd,
        remark=remark,
    )


def _square(lower: FloatArray) -> FloatArray:
    """Symmetric matrices, (..., 3, 3), from their lower halves, (..., 6)."""
    full = np.empty((*lower.shape[:-1], 3, 3))
    full[..., _ROWS, _COLUMNS] = lower
    full[..., _COLUMNS, _ROWS] = lower
    return full
