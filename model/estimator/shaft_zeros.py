"""Whether a shaft's zero is wrong: what the loads of all feet say of it over some seconds of walking.

A zero that is off by a small angle lifts or lowers its foot by the slope of its path, down while it
touches down and up while it lifts off; a leg that is longer, or stiffer, does the same all along the
stance. The loads at robots with one foot higher (``model.estimator.tolerances``) say what a height does
to every foot. So the loads that the model leaves are fitted by least squares with a height and an angle
of each leg. It is evidence for a remark, and no part of the state: other errors of a robot file leave
traces of a few degrees, so that only one angle that stands out is named.
"""

from dataclasses import replace

import numpy as np

from model.estimator.senses import Heard
from model.estimator.settings import RECORD_S
from model.estimator.tolerances import Apart
from model.values.arrays import FloatArray, readonly
from model.values.estimate import ZeroEvidence

EVERY = 4  # records: the next ones say the same
MEMORY_S = 20.0
LEAST_S = 8.0  # of records that all name the same leg, before it is named
SMALL_RAD = np.radians(5.0)  # what other errors of a file look like
STANDS_OUT = 2.5  # times the next largest angle
SURE = 4.0  # standard deviations
EXPLAINS = 0.3  # by that angle alone, of what heights leave of the loads
SEEN = 0.5  # of the median information, by every leg: loads of one not seen yet go to another
COLOUR = 25.0  # records in a row that say the same: loads that the model leaves last for a second
NO_LEG = -1
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
    slope_m: FloatArray | None,
    companion_m: float,
) -> ZeroEvidence:
    """Take the loads of a tick into account.

    Args:
        before: What was known.
        heard: Forces of the tick.
        expected: Loads at the state over the weight, (N,).
        apart: What companions with other heights answered; None without an answer.
        slope_m: Slope of each foot's height over its shaft's angle, (N,) [m/rad]; NaN while a shaft rests.
            None where legs have no shafts.
        companion_m: By how much a companion's foot is higher.
    """
    if apart is None or slope_m is None or not (heard.fresh and heard.whole):
        return before
    records = before.records + 1
    if records % EVERY:
        return replace(before, records=records)
    legs = len(expected)
    left = heard.share[:, 2] - expected
    if not np.isfinite(left).all():
        return replace(before, records=records)
    half = len(apart.load_share) // 2
    by_height = 0.5 * (apart.load_share[:legs] - apart.load_share[half : half + legs]).T
    signature = np.hstack([by_height, by_height * (np.nan_to_num(slope_m) / LENGTH_M)])
    keep = np.exp(-EVERY * RECORD_S / MEMORY_S)
    information = keep * before.information + signature.T @ signature
    pull = keep * before.pull + signature.T @ left
    square = keep * before.square + [float(left @ left), legs]
    angle, standing_out = before.angle_rad, NO_LEG
    ridge = RIDGE * float(information.trace()) / len(pull)
    if ridge > 0.0:
        spread = np.linalg.inv(information + ridge * np.eye(len(pull)))
        fitted = spread @ pull
        unexplained = max(float(square[0] - fitted @ pull), 0.0) / square[1]
        sd = np.sqrt(COLOUR * unexplained * spread.diagonal())
        unit = companion_m / LENGTH_M
        angle = readonly(unit * np.stack([fitted[legs:], sd[legs:]]))
        standing_out = _standing_out(angle, _alone(information, pull, ridge, float(square[0])))
    since = before.since if standing_out == before.standing_out else records
    sure = (records - since) * RECORD_S >= LEAST_S
    return ZeroEvidence(
        readonly(information), readonly(pull), readonly(square), records, angle,
        standing_out, since, standing_out if sure else NO_LEG,
    )  # fmt: skip


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


def _standing_out(angle_rad: FloatArray, share: FloatArray) -> int:
    """Return the leg whose zero seems wrong, ``NO_LEG`` if none stands out."""
    size, sd = np.abs(angle_rad[0]), angle_rad[1]
    leg = int(size.argmax())
    next_largest = float(np.sort(size)[-2])
    sure = size[leg] >= max(SMALL_RAD, SURE * sd[leg], STANDS_OUT * next_largest)
    return leg if sure and share[leg] >= max(EXPLAINS, float(share.max())) else NO_LEG
