"""Where the numbers of an estimator's state and estimate lie in rows of arrays, a row a tick.

A state is made of forty arrays. To make them again in each tick, and to hand them to compiled code, takes
longer than to compute what is in them. In a block of ticks each kind of number, real, whole and flag, has
one array, and a field is a part of its rows. Row 0 is the state before the first tick.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import nan, prod, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.compiled import compiled
from model.estimator.sources import places_needed
from model.estimator.tolerances import robots_beside
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.estimate import (
    BIAS,
    FIXED,
    GYRO_BIAS,
    NEVER,
    SOURCES,
    VELOCITY,
    YAW,
    Companions,
    Estimate,
    EstimatorState,
    ForceMemory,
    Health,
    SourceMemory,
    Vibration,
    ZeroEvidence,
)
from model.values.legs import FootMotion

KINDS = len(SOURCES)
# Real numbers of a state.
(
    MEAN, COVARIANCE, SHARE, EXPECTED, MEAN_BEFORE, COVARIANCE_BEFORE, TRANSITION, TWIST, APART,
    APART_COVARIANCE, PRODUCT, NORMAL, LAST, SOURCE_BIAS, MISFIT, SCALE, COLOUR, FORCE_APART,
    FORCE_AGREE, BALANCE, STRAIN, SHAKE, SHAKE_CHANGE, TURN, INFORMATION, PULL, SQUARE, ZERO,
) = range(28)  # fmt: skip
# Of an estimate, beside those of the state after it.
BY_FOOT, BODY, TILT, FORCE_SPREAD, FORCE, INNOVATION, SOURCE_NIS, FIT = range(28, 36)
NIS, LIKELIHOOD, HEIGHT = range(3)  # in FIT
# Whole numbers.
(
    T_NS, FORCE_NS, USED_NS, IDLE_NS, ANSWER_NS, FINE_NS, GYRO_NS, REJECTS, FAR_POSES, RECORDS,
    STANDING_OUT, SINCE, SUSPECTED, NUMBERS, REJECTED, SOURCE_NS, SOURCE_DOF,
) = range(17)  # fmt: skip
# Flags.
LOST, AIRBORNE, ANCHORED, CONTACT, RESTING, SLIPPING = range(6)
# Numbers of a tick that nobody asks for afterwards.
HEARD, ROWS, SLIP, SWAY, APART_VELOCITY, APART_SHARE, NOISE, SHAKING, DOUBT, TOTAL, RIDGE = range(
    11
)


@dataclass(frozen=True, slots=True, eq=False)
class Shapes:
    """Shape of each field by its number, and where it begins in a row.

    Attributes:
        real: Shapes of the real numbers.
        whole: Of the whole numbers.
        flags: Of the flags.
        spare: Of what nobody asks for afterwards.
        at: Where each begins: real, whole, flags, spare, a row each, (4, 36).
        sizes: Length of a row of each kind.
    """

    real: tuple[tuple[int, ...], ...]
    whole: tuple[tuple[int, ...], ...]
    flags: tuple[tuple[int, ...], ...]
    spare: tuple[tuple[int, ...], ...]
    at: IntArray
    sizes: tuple[int, ...]


def _in_order(shape_of: Mapping[int, tuple[int, ...]]) -> tuple[tuple[int, ...], ...]:
    """Shapes by the numbers of the fields, of which none may be missing."""
    return tuple(shape_of[name] for name in range(len(shape_of)))


@cache
def shapes(legs: int) -> Shapes:
    """Return where everything lies for N legs."""
    size, robots, kinds = FIXED + 2 * legs, robots_beside(legs), KINDS
    places = places_needed(legs)
    square, by_robot, by_kind, each = (size, size), (robots, 3), (kinds,), (places,)
    feet, both, legs_and_axes = (legs, 3), 2 * legs, (legs, 3, 3)
    real = _in_order({
        MEAN: (size,), COVARIANCE: square, SHARE: (legs,), EXPECTED: feet, MEAN_BEFORE: (size,),
        COVARIANCE_BEFORE: square, TRANSITION: square, TWIST: by_robot, APART: by_robot,
        APART_COVARIANCE: (3, 3), PRODUCT: by_kind, NORMAL: by_kind, LAST: each, SOURCE_BIAS: each,
        MISFIT: by_kind, SCALE: by_kind, COLOUR: by_kind, FORCE_APART: (2,), FORCE_AGREE: (2,),
        BALANCE: (4,), STRAIN: (3,), SHAKE: (3,), SHAKE_CHANGE: (3,), TURN: (2,),
        INFORMATION: (both, both), PULL: (both,), SQUARE: (2,), ZERO: (2, legs),
        BY_FOOT: (6, legs), BODY: (2, 3, 3), TILT: (2,), FORCE_SPREAD: legs_and_axes, FORCE: feet,
        INNOVATION: feet, SOURCE_NIS: by_kind, FIT: (3,),
    })  # fmt: skip
    single = dict.fromkeys(range(REJECTED), ())
    whole = _in_order(single | {REJECTED: (kinds, legs), SOURCE_NS: by_kind, SOURCE_DOF: by_kind})
    flags = _in_order({
        LOST: (), AIRBORNE: (), ANCHORED: (), CONTACT: (legs,), RESTING: (robots, legs),
        SLIPPING: (legs,),
    })  # fmt: skip
    spare = _in_order({
        HEARD: feet, ROWS: (1 + 3 * legs, 6 + 3 * legs), SLIP: (legs, 2), SWAY: (2,),
        APART_VELOCITY: by_robot, APART_SHARE: (robots, legs), NOISE: square, SHAKING: (3,),
        DOUBT: feet, TOTAL: (1,), RIDGE: (1,),
    })  # fmt: skip
    kinds_of = (real, whole, flags, spare)
    at, sizes = np.zeros((len(kinds_of), len(real)), dtype=np.int64), []
    for row, kind in zip(at, kinds_of, strict=True):
        ends = np.cumsum([prod(shape) for shape in kind])
        row[1 : len(kind)] = ends[:-1]
        sizes.append(int(ends[-1]))
    return Shapes(*kinds_of, readonly(at), tuple(sizes))


@compiled
def vector(row: Any, at: int, count: int) -> Any:
    """Some numbers of a row."""
    return row[at : at + count]


@compiled
def matrix(row: Any, at: int, first: int, second: int) -> Any:
    """Some numbers of a row, (first, second)."""
    return row[at : at + first * second].reshape(first, second)


class StateRows:
    """States after each of T ticks, and what the estimator reports in it.

    Args:
        legs: N.
        count: T.

    Attributes:
        real: Real numbers, (T + 1, ...).
        whole: Whole numbers, the same way.
        flags: Flags, the same way.
        spare: Numbers of the latest tick.
    """

    def __init__(self, legs: int, count: int) -> None:
        self._shapes = shapes(legs)
        real, whole, flags, spare = self._shapes.sizes
        self.real = np.empty((count + 1, real))
        self.whole = np.empty((count + 1, whole), dtype=np.int64)
        self.flags = np.empty((count + 1, flags), dtype=np.bool_)
        self.spare = np.empty(spare)
        # numbers that are handed out are not to be written to
        self._real, self._flags = readonly(self.real.view()), readonly(self.flags.view())
        self._whole = readonly(self.whole.view())

    def reals(self, name: int) -> FloatArray:
        """A field of real numbers in every row, (T + 1, ...)."""
        return _field(self.real, self._shapes.at[0, name], self._shapes.real[name])

    def wholes(self, name: int) -> IntArray:
        """A field of whole numbers in every row, (T + 1, ...)."""
        return _field(self.whole, self._shapes.at[1, name], self._shapes.whole[name])

    def all_flags(self, name: int) -> NDArray[np.bool_]:
        """A field of flags in every row, (T + 1, ...)."""
        return _field(self.flags, self._shapes.at[2, name], self._shapes.flags[name])

    def scratch(self, name: int) -> FloatArray:
        """A field of the latest tick that nobody asks for afterwards."""
        at, shape = int(self._shapes.at[3, name]), self._shapes.spare[name]
        return self.spare[at : at + prod(shape)].reshape(shape)

    def lay_state(self, k: int, state: EstimatorState) -> None:
        """Write a state into row k."""
        real, whole, flags = _parts(state)
        for row, values, places, fields in (
            (self.real[k], real, self._shapes.at[0], self._shapes.real),
            (self.whole[k], whole, self._shapes.at[1], self._shapes.whole),
            (self.flags[k], flags, self._shapes.at[2], self._shapes.flags),
        ):
            for name, value in values.items():
                at, shape = int(places[name]), fields[name]
                row[at : at + prod(shape)] = np.ravel(value)

    def lay_estimate(self, k: int, estimated: Estimate) -> None:
        """Write what was estimated, beside the state after it, into row k."""
        by_foot = [
            estimated.mu, estimated.mu_sd, estimated.stiffness, estimated.stiffness_sd,
            estimated.load_share, estimated.load_share_sd,
        ]  # fmt: skip
        for name, value in {
            BY_FOOT: np.stack(by_foot),
            BODY: np.stack([estimated.pose_covariance, estimated.twist_covariance]),
            TILT: estimated.tilt_rad, FORCE_SPREAD: estimated.force_covariance, FORCE: estimated.force_B,
            INNOVATION: estimated.innovation, SOURCE_NIS: estimated.source_nis,
            FIT: np.array([estimated.nis, estimated.log_likelihood, estimated.height_m]),
        }.items():  # fmt: skip
            self.reals(name)[k] = value
        self.wholes(NUMBERS)[k], self.wholes(SOURCE_DOF)[k] = (
            estimated.nis_dof,
            estimated.source_dof,
        )
        self.all_flags(SLIPPING)[k] = estimated.slipping

    def state(self, k: int, feet: FootMotion) -> EstimatorState:
        """Return the state of row k, which views the rows.

        Args:
            k: Which.
            feet: Of its tick.
        """
        real, whole, flags = self._of_row(k)
        t_ns, force_ns, used_ns, idle_ns, answer_ns, fine_ns, gyro_ns = whole[:REJECTS]
        rejects, far_poses, records, standing_out, since, suspected = whole[REJECTS:NUMBERS]
        return EstimatorState(
            t_ns=t_ns, mean=real[MEAN], covariance=real[COVARIANCE], feet=feet, force_ns=force_ns,
            used_ns=used_ns, share=real[SHARE], expected=real[EXPECTED], contact=flags[CONTACT],
            rejected=whole[REJECTED], rejects=rejects, idle_ns=idle_ns, answer_ns=answer_ns,
            fine_ns=fine_ns, lost=flags[LOST], airborne=flags[AIRBORNE], anchored=flags[ANCHORED],
            far_poses=far_poses, before=(real[MEAN_BEFORE], real[COVARIANCE_BEFORE]),
            transition=real[TRANSITION],
            companions=Companions(
                real[TWIST], flags[RESTING], real[APART], real[APART_COVARIANCE]
            ),
            sources=SourceMemory(
                whole[SOURCE_NS], real[PRODUCT], real[NORMAL], real[LAST], real[SOURCE_BIAS],
                real[MISFIT], real[SCALE], real[COLOUR],
            ),
            forces=ForceMemory(real[FORCE_APART], real[FORCE_AGREE]), balance=real[BALANCE],
            strain=real[STRAIN],
            vibration=Vibration(real[SHAKE], real[SHAKE_CHANGE], *real[TURN].tolist()),
            zeros=ZeroEvidence(
                real[INFORMATION], real[PULL], real[SQUARE], records, real[ZERO], standing_out, since,
                suspected,
            ),
            gyro_ns=gyro_ns,
        )  # fmt: skip

    def estimate(self, k: int, words: "Wording") -> Estimate:
        """Return what the estimator reports in the tick that led to row k.

        Args:
            k: Which.
            words: What of it is no number.
        """
        real, whole, flags = self._of_row(k)
        mean, by_foot, body, fit = real[MEAN], real[BY_FOOT], real[BODY], real[FIT].tolist()
        t_ns, force_ns = whole[T_NS], whole[FORCE_NS]
        gyro = whole[GYRO_NS] != NEVER
        return Estimate(
            t_ns, mean[:2], float(mean[YAW]), mean[VELOCITY], body[0], real[APART], body[1],
            mean[BIAS], by_foot[0], by_foot[1], by_foot[2], by_foot[3], real[FORCE],
            real[FORCE_SPREAD], by_foot[4], by_foot[5], real[TILT], fit[HEIGHT], flags[CONTACT],
            flags[SLIPPING], words.holding, fit[NIS], whole[NUMBERS], real[SOURCE_NIS],
            whole[SOURCE_DOF], real[SCALE], fit[LIKELIHOOD], real[INNOVATION], whole[REJECTS],
            nan if force_ns == NEVER else (t_ns - force_ns) * 1e-9, words.health, words.reason,
            float(mean[GYRO_BIAS]) if gyro else nan,
            sqrt(real[COVARIANCE][GYRO_BIAS, GYRO_BIAS]) if gyro else nan, words.remark,
        )  # fmt: skip

    def zeros(self, k: int) -> ZeroEvidence:
        """Return what row k says of the shafts' zeros."""
        real, whole, _ = self._of_row(k)
        return ZeroEvidence(
            real[INFORMATION], real[PULL], real[SQUARE], whole[RECORDS], real[ZERO],
            whole[STANDING_OUT], whole[SINCE], whole[SUSPECTED],
        )  # fmt: skip

    def lay_zeros(self, k: int, zeros: ZeroEvidence) -> None:
        """Write what is known of the shafts' zeros into row k."""
        for name, value in (
            (INFORMATION, zeros.information), (PULL, zeros.pull), (SQUARE, zeros.square),
            (ZERO, zeros.angle_rad),
        ):  # fmt: skip
            self.reals(name)[k] = value
        for name, number in (
            (RECORDS, zeros.records), (STANDING_OUT, zeros.standing_out), (SINCE, zeros.since),
            (SUSPECTED, zeros.suspected),
        ):  # fmt: skip
            self.wholes(name)[k] = number

    def _of_row(self, k: int) -> tuple[list[Any], list[Any], list[Any]]:
        """All fields of a row, by their numbers; single whole numbers and flags as Python's."""
        parts = _slices(self._shapes)
        real = [self._real[k, part].reshape(shape) for part, shape in parts[0]]
        whole = self._whole[k].tolist()[:REJECTED]
        whole += [self._whole[k, part].reshape(shape) for part, shape in parts[1][REJECTED:]]
        flags = self._flags[k].tolist()[:CONTACT]
        flags += [self._flags[k, part].reshape(shape) for part, shape in parts[2][CONTACT:]]
        return real, whole, flags


@dataclass(frozen=True, slots=True)
class Wording:
    """What of an estimate is no number."""

    holding: bool = False
    health: Health = Health.OK
    reason: str = ""
    remark: str = ""


def _field(rows: NDArray[Any], at: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    part: NDArray[Any] = rows[:, at : at + prod(shape)].reshape(len(rows), *shape)
    return part


@cache
def _slices(of: Shapes) -> tuple[tuple[tuple[slice, tuple[int, ...]], ...], ...]:
    """Part of a row and shape, of each field of the real numbers, whole numbers and flags."""
    return tuple(
        tuple(
            (slice(int(at), int(at) + prod(shape)), shape)
            for at, shape in zip(places, fields, strict=False)
        )
        for places, fields in zip(of.at, (of.real, of.whole, of.flags), strict=False)
    )


def _parts(state: EstimatorState) -> tuple[dict[int, Any], dict[int, Any], dict[int, Any]]:
    """What a state holds, by the numbers of the fields: real, whole, flags."""
    with_robots, known, zeros = state.companions, state.sources, state.zeros
    shaking = state.vibration
    real = {
        MEAN: state.mean, COVARIANCE: state.covariance, SHARE: state.share,
        EXPECTED: state.expected, MEAN_BEFORE: state.before[0], COVARIANCE_BEFORE: state.before[1],
        TRANSITION: state.transition, TWIST: with_robots.twist, APART: with_robots.apart,
        APART_COVARIANCE: with_robots.pose_covariance, PRODUCT: known.product,
        NORMAL: known.normal, LAST: known.last, SOURCE_BIAS: known.bias, MISFIT: known.misfit,
        SCALE: known.scale, COLOUR: known.colour, FORCE_APART: state.forces.apart,
        FORCE_AGREE: state.forces.agree, BALANCE: state.balance, STRAIN: state.strain,
        SHAKE: shaking.force, SHAKE_CHANGE: shaking.force_change,
        TURN: (shaking.turn, shaking.turn_change), INFORMATION: zeros.information,
        PULL: zeros.pull, SQUARE: zeros.square, ZERO: zeros.angle_rad,
    }  # fmt: skip
    whole = {
        T_NS: state.t_ns, FORCE_NS: state.force_ns, USED_NS: state.used_ns, IDLE_NS: state.idle_ns,
        ANSWER_NS: state.answer_ns, FINE_NS: state.fine_ns, GYRO_NS: state.gyro_ns,
        REJECTS: state.rejects, FAR_POSES: state.far_poses, RECORDS: zeros.records,
        STANDING_OUT: zeros.standing_out, SINCE: zeros.since, SUSPECTED: zeros.suspected,
        REJECTED: state.rejected, SOURCE_NS: known.t_ns,
    }  # fmt: skip
    flags = {
        LOST: state.lost, AIRBORNE: state.airborne, ANCHORED: state.anchored,
        CONTACT: state.contact, RESTING: with_robots.resting,
    }  # fmt: skip
    return real, whole, flags
