"""Estimates of a block as columns: a field in all ticks at once, without an object for each."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.estimator.block import places as at
from model.estimator.block.run import USUAL, EstimatedBlock
from model.values.estimate import BIAS, GYRO_BIAS, NEVER, VELOCITY, YAW, Health

Column = NDArray[Any]


class BlockFields:
    """Fields of the estimates of T ticks.

    Args:
        block: The ticks.
    """

    def __init__(self, block: EstimatedBlock) -> None:
        self._block = block
        self._words = [block.wordings.get(row, USUAL) for row in range(1, len(block) + 1)]

    def __len__(self) -> int:
        return len(self._block)

    def column(self, name: str) -> Column:
        """Return a field in numbers, (T, ...); its names are those of ``Estimate``."""
        if name == "holding":
            return np.array([words.holding for words in self._words], dtype=np.bool_)
        return _TAKEN[name](self._block.rows)[1:]

    def texts(self, name: str) -> list[str]:
        """Return the reason or the remark of each."""
        return [getattr(words, name) for words in self._words]

    def healths(self) -> list[Health]:
        """Return the verdict in each."""
        return [words.health for words in self._words]


def _mean(part: slice | int) -> Callable[[at.StateRows], Column]:
    return lambda rows: rows.reals(at.MEAN)[:, part]


def _real(field: int, place: int | None = None) -> Callable[[at.StateRows], Column]:
    if place is None:
        return lambda rows: rows.reals(field)
    return lambda rows: rows.reals(field)[:, place]


def _whole(field: int) -> Callable[[at.StateRows], Column]:
    return lambda rows: rows.wholes(field)


def _force_age_s(rows: at.StateRows) -> Column:
    known = rows.wholes(at.FORCE_NS)
    return np.where(known == NEVER, np.nan, (rows.wholes(at.T_NS) - known) * 1e-9)


def _with_gyro(take: Callable[[at.StateRows], Column]) -> Callable[[at.StateRows], Column]:
    return lambda rows: np.where(rows.wholes(at.GYRO_NS) == NEVER, np.nan, take(rows))


def _gyro_bias_sd(rows: at.StateRows) -> Column:
    variance = rows.reals(at.COVARIANCE)[1:, GYRO_BIAS, GYRO_BIAS]
    return np.concatenate([[np.nan], np.sqrt(variance)])


_TAKEN: Mapping[str, Callable[[at.StateRows], Column]] = MappingProxyType(
    {
        "t_ns": _whole(at.T_NS),
        "position_m": _mean(slice(2)),
        "yaw_rad": _mean(YAW),
        "velocity_B": _mean(VELOCITY),
        "pose_covariance": _real(at.BODY, 0),
        "companion_pose": _real(at.APART),
        "twist_covariance": _real(at.BODY, 1),
        "bias_B": _mean(BIAS),
        "mu": _real(at.BY_FOOT, 0),
        "mu_sd": _real(at.BY_FOOT, 1),
        "stiffness": _real(at.BY_FOOT, 2),
        "stiffness_sd": _real(at.BY_FOOT, 3),
        "force_B": _real(at.FORCE),
        "force_covariance": _real(at.FORCE_SPREAD),
        "load_share": _real(at.BY_FOOT, 4),
        "load_share_sd": _real(at.BY_FOOT, 5),
        "tilt_rad": _real(at.TILT),
        "height_m": _real(at.FIT, at.HEIGHT),
        "contact": lambda rows: rows.all_flags(at.CONTACT),
        "slipping": lambda rows: rows.all_flags(at.SLIPPING),
        "nis": _real(at.FIT, at.NIS),
        "nis_dof": _whole(at.NUMBERS),
        "source_nis": _real(at.SOURCE_NIS),
        "source_dof": _whole(at.SOURCE_DOF),
        "noise_scale": _real(at.SCALE),
        "log_likelihood": _real(at.FIT, at.LIKELIHOOD),
        "innovation": _real(at.INNOVATION),
        "rejects": _whole(at.REJECTS),
        "force_age_s": _force_age_s,
        "gyro_bias_rad_s": _with_gyro(_mean(GYRO_BIAS)),
        "gyro_bias_sd": _with_gyro(_gyro_bias_sd),
    }
)
