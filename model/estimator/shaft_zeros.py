"""Whether a shaft's zero is wrong: what the loads of all feet say of it over some seconds of walking.

A zero that is off by a small angle lifts or lowers its foot by the slope of its path, down while it
touches down and up while it lifts off; a leg that is longer, or stiffer, does the same all along the
stance. The loads at robots with one foot higher (``model.estimator.tolerances``) say what a height does
to every foot. So the loads that the model leaves are fitted by least squares with a height and an angle
of each leg. It is evidence for a remark, and no part of the state: other errors of a robot file leave
traces of a few degrees, so that only one angle that stands out is named.
"""

import numpy as np

from model.compiled import NUMBER, compile_for, compiled, given, out
from model.estimator.senses import Heard
from model.estimator.settings import RECORD_S
from model.estimator.tolerances import Apart
from model.values.arrays import FloatArray, readonly
from model.values.estimate import ZeroEvidence

EVERY = 4  # records: the next ones say the same
MEMORY_S = 20.0
LEAST_S = 8.0  # of records that all name the same leg, before it is named
SMALL_RAD = float(np.radians(5.0))  # what other errors of a file look like
STANDS_OUT = 2.5  # times the next largest angle
SURE = 4.0  # standard deviations
EXPLAINS = 0.3  # by that angle alone, of what heights leave of the loads
SEEN = 0.5  # of the median information, by every leg: loads of one not seen yet go to another
COLOUR = 25.0  # records in a row that say the same: loads that the model leaves last for a second
NO_LEG = -1
LEAST_RATE_RAD_S = 0.05  # of a shaft that turns
LENGTH_M = 0.01  # the unit of slopes, so that both kinds of columns are of one size
RIDGE = 1e-6


def at_start(legs: int) -> ZeroEvidence:
    """What is known before the first record."""
    both = 2 * legs
    unknown = np.stack([np.zeros(legs), np.full(legs, np.inf)])
    return ZeroEvidence(
        readonly(np.zeros((both, both))), readonly(np.zeros(both)), readonly(np.zeros(2)), 0,
        readonly(unknown), NO_LEG, 0, NO_LEG,
    )  # fmt: skip


def learn(
    before: ZeroEvidence,
    heard: Heard,
    expected: FloatArray,
    apart: Apart | None,
    speed_m_s: FloatArray,
    shaft_rad_s: FloatArray | None,
    companion_m: float,
) -> ZeroEvidence:
    """Take the loads of a tick into account.

    Args:
        before: What was known.
        heard: Forces of the tick.
        expected: Forces at the state over the weight, (N, 3).
        apart: What companions with other heights answered; None without an answer.
        speed_m_s: Of the feet, (N, 3); NaN for a leg without encoder.
        shaft_rad_s: Of their shafts, (N,); None where legs have no shafts.
        companion_m: By how much a companion's foot is higher.
    """
    if apart is None or shaft_rad_s is None or not (heard.fresh and heard.whole):
        return before
    records = before.records + 1
    if records % EVERY:
        return _counted(before, records)
    information, pull = before.information.copy(), before.pull.copy()
    square, angle = before.square.copy(), before.angle_rad.copy()
    ridge = evidence_kernel(
        heard.share, expected, apart.load_share, np.ascontiguousarray(speed_m_s), shaft_rad_s,
        companion_m, information, pull, square, angle,
    )  # fmt: skip
    if ridge < 0.0:
        return _counted(before, records)
    standing_out = NO_LEG
    if ridge > 0.0:
        standing_out = _standing_out(angle, information, pull, ridge, float(square[0]))
    since = before.since if standing_out == before.standing_out else records
    sure = (records - since) * RECORD_S >= LEAST_S
    return ZeroEvidence(
        readonly(information), readonly(pull), readonly(square), records, readonly(angle),
        standing_out, since, standing_out if sure else NO_LEG,
    )  # fmt: skip


def _standing_out(
    angle_rad: FloatArray, information: FloatArray, pull: FloatArray, ridge: float, square: float
) -> int:
    """Return the leg whose zero seems wrong, ``NO_LEG`` if none stands out.

    Its angle is large, and explains by itself what heights leave.
    """
    sizes, sd = np.abs(angle_rad[0]).tolist(), angle_rad[1].tolist()
    leg = sizes.index(max(sizes))
    next_largest = sorted(sizes)[-2]
    if sizes[leg] < max(SMALL_RAD, SURE * sd[leg], STANDS_OUT * next_largest):
        return NO_LEG
    share = _alone(information, pull, ridge, square)
    return leg if share[leg] >= max(EXPLAINS, float(share.max())) else NO_LEG


def _alone(information: FloatArray, pull: FloatArray, ridge: float, square: float) -> FloatArray:
    """Return the share that each leg's angle by itself explains of what all heights leave.

    It is 0 until all legs were seen.
    """
    legs = len(pull) // 2
    height, both = information[:legs, :legs] + ridge * np.eye(legs), information[:legs, legs:]
    solved = np.linalg.solve(height, np.column_stack([pull[:legs], both]))
    left = square - float(pull[:legs] @ solved[:, 0])
    known = (information[legs:, legs:] - both.T @ solved[:, 1:]).diagonal()
    if left <= 0.0 or known.min() < SEEN * float(np.median(known)):
        return np.zeros(legs)
    return np.asarray((pull[legs:] - both.T @ solved[:, 0]) ** 2 / (known + ridge) / left)


def _counted(before: ZeroEvidence, records: int) -> ZeroEvidence:
    """The same evidence after so many records."""
    return ZeroEvidence(
        before.information, before.pull, before.square, records, before.angle_rad,
        before.standing_out, before.since, before.suspected,
    )  # fmt: skip


@compiled
def evidence_kernel(
    share: FloatArray, expected: FloatArray, apart: FloatArray, speed_m_s: FloatArray,
    shaft_rad_s: FloatArray, companion_m: float, information: FloatArray, pull: FloatArray,
    square: FloatArray, angle: FloatArray,
) -> float:  # fmt: skip
    """Take the loads of a record into account, and fit a height and an angle of each leg.

    Args:
        share: Measured forces over the weight, (N, 3).
        expected: Forces at the state over the weight, (N, 3).
        apart: Loads of the companions, of ``Apart``, (M, N).
        speed_m_s: Of the feet, (N, 3).
        shaft_rad_s: Of their shafts, (N,).
        companion_m: As in ``learn``.
        information: In and out: of ``ZeroEvidence``, as are the next three.
        pull: In and out.
        square: In and out.
        angle: In and out.

    Returns:
        What was added to the diagonal of the information, so that it has an inverse; 0 where nothing could
        be fitted, -1 where a load is no number and nothing was learned.
    """
    legs, both = shaft_rad_s.size, pull.size
    half = apart.shape[0] // 2
    for k in range(legs):
        if not abs(share[k, 2] - expected[k, 2]) < np.inf:
            return -1.0
    keep = np.exp(-EVERY * RECORD_S / MEMORY_S)
    for i in range(both):
        pull[i] *= keep
        for j in range(both):
            information[i, j] *= keep
    square[0], square[1] = keep * square[0], keep * square[1] + legs
    row = np.empty(both)
    for k in range(legs):
        left = share[k, 2] - expected[k, 2]
        for i in range(legs):
            row[i] = 0.5 * (apart[i, k] - apart[half + i, k])
            slope = 0.0  # of height over the shaft's angle; not known while it rests
            if abs(shaft_rad_s[i]) > LEAST_RATE_RAD_S and abs(speed_m_s[i, 2]) < np.inf:
                slope = speed_m_s[i, 2] / shaft_rad_s[i]
            row[legs + i] = row[i] * (slope / LENGTH_M)
        for i in range(both):
            pull[i] += row[i] * left
            for j in range(both):
                information[i, j] += row[i] * row[j]
        square[0] += left * left
    trace = 0.0
    for i in range(both):
        trace += information[i, i]
    ridge = RIDGE * trace / both
    if not ridge > 0.0:
        return 0.0
    _fit(information, pull, square, ridge, companion_m / LENGTH_M, angle)
    return ridge


@compiled
def _fit(
    information: FloatArray, pull: FloatArray, square: FloatArray, ridge: float, unit: float,
    angle: FloatArray,
) -> None:  # fmt: skip
    """Fit heights and angles; the information, with the ridge, is positive definite."""
    both = pull.size
    inverse = information.copy()
    for i in range(both):
        inverse[i, i] += ridge
    for i in range(both):  # Gauss and Jordan in place, with pivots that are never small
        pivot = 1.0 / inverse[i, i]
        inverse[i, i] = 1.0
        for k in range(both):
            inverse[i, k] *= pivot
        for j in range(both):
            if j != i:
                share = inverse[j, i]
                inverse[j, i] = 0.0
                for k in range(both):
                    inverse[j, k] -= share * inverse[i, k]
    explained = 0.0
    for i in range(both):
        fitted = 0.0
        for k in range(both):
            fitted += inverse[i, k] * pull[k]
        explained += fitted * pull[i]
        if i >= both // 2:
            angle[0, i - both // 2] = unit * fitted
    unexplained = max(square[0] - explained, 0.0) / square[1]
    for k in range(both // 2):
        spread = inverse[both // 2 + k, both // 2 + k]
        angle[1, k] = unit * np.sqrt(COLOUR * unexplained * spread)


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(evidence_kernel, *given(2, 2, 2, 2, 1), NUMBER, *out(2, 1, 1, 2))
