"""The estimator over a block of ticks: usual ones in rows of arrays, all others by the filter itself.

A usual tick takes three compiled calls, between which filterpy predicts and corrects. What a tick made is
put together as objects only where somebody asks for it.
"""

from typing import Any

import numpy as np

from model.estimator.block import measure, predict, settle
from model.estimator.block import places as at
from model.estimator.block.inputs import BlockInputs
from model.estimator.block.measure import expect_in_row_kernel, weigh_in_row_kernel
from model.estimator.block.places import StateRows, Wording, shapes
from model.estimator.block.predict import UNUSUAL, predict_kernel
from model.estimator.block.settle import NOT_MEASURED, NOTABLE, ZEROS_DUE, settle_in_row_kernel
from model.estimator.filter import HEIGHT, Estimator
from model.estimator.health import remarks
from model.estimator.history import EstimatorMemory
from model.estimator.neighbourhood import no_answer
from model.estimator.senses import Heard
from model.estimator.shaft_zeros import learn
from model.estimator.tolerances import Apart, design
from model.values.estimate import Estimate, EstimatorState, OdometryInputs
from model.values.legs import FootMotion

NOTHING_WEIGHED = (0, NOT_MEASURED, np.nan, np.nan)
USUAL = Wording()


class EstimatedBlock:
    """States and estimates of the ticks of a block.

    Args:
        before: What was remembered before the first of them.
        inputs: What was known in them.
        legs: N.
        memory_s: How late a sample may be [s].

    Attributes:
        rows: Numbers of them all.
        wordings: What is no number, by row, where it is not that of a usual tick.
        left: How many ticks were left to the filter.
    """

    def __init__(
        self, before: EstimatorMemory, inputs: BlockInputs, legs: int, memory_s: float
    ) -> None:
        self.before, self.inputs = before, inputs
        self.rows = StateRows(legs, len(inputs.t_ns))
        self.wordings: dict[int, Wording] = {}
        self.left = 0
        self._states: dict[int, EstimatorState] = {0: before.state}
        self._limit_ns = round(memory_s * 1e9)
        self.rows.lay_state(0, before.state)

    def __len__(self) -> int:
        return len(self.inputs.t_ns)

    def estimate(self, k: int) -> Estimate:
        """Return what the estimator says in tick k."""
        return self.rows.estimate(k + 1, self.wordings.get(k + 1, USUAL))

    def state(self, row: int) -> EstimatorState:
        """Return the state before tick ``row``; that after the last tick is in row T."""
        known = self._states.get(row)
        if known is None:
            known = self.rows.state(row, self.feet(row - 1))
            self._states[row] = known
        return known

    def keep(self, k: int, state: EstimatorState, estimated: Estimate) -> None:
        """Take what the filter itself made of tick k."""
        self.left += 1
        self.rows.lay_state(k + 1, state)
        self.rows.lay_estimate(k + 1, estimated)
        self._states[k + 1] = state
        self.wordings[k + 1] = Wording(
            estimated.holding, estimated.health, estimated.reason, estimated.remark
        )

    def feet(self, k: int) -> FootMotion:
        """Return the feet of tick k."""
        return FootMotion(self.inputs.position_m[k], self.inputs.velocity_m_s[k])

    def memory(self, row: int) -> EstimatorMemory:
        """Return what is remembered before tick ``row``: as ``history.advance`` leaves it."""
        if row == 0:
            return self.before
        times = [known.t_ns for _, known in self.before.ticks] + self.inputs.t_ns[:row].tolist()
        earlier, first = len(self.before.ticks), 0
        for now in range(earlier, len(times)):
            while abs(times[now] - times[first]) > self._limit_ns:
                first += 1
        ticks: list[tuple[EstimatorState, OdometryInputs]] = [*self.before.ticks[first:]]
        since = range(max(first - earlier, 0), row)
        ticks += [(self.state(k), self.inputs.of_tick(k)) for k in since]
        return EstimatorMemory(self.state(row), tuple(ticks), self.before.refused)


class BlockEstimator:
    """The filter over blocks of ticks.

    Args:
        estimator: The filter.
        memory_s: How late a sample may be [s].

    Attributes:
        estimator: The same.
        stack: Work space: of ``feet_stack_kernel``.
        room: Work space: of ``weigh_in_row_kernel``.
        work: Work space: of ``settle_in_row_kernel``.
    """

    def __init__(self, estimator: Estimator, memory_s: float) -> None:
        self.estimator, self._memory_s = estimator, memory_s
        most, size = 3 * estimator.legs + 1, estimator.size
        self.stack = (
            np.empty(most), np.empty((most, size)), np.empty(most), np.empty(most),
            np.empty((most, 3), dtype=np.int64),
        )  # fmt: skip
        self.room, self.work = np.empty(3 * most, dtype=np.int64), np.empty((size, size))
        for module in (predict, measure, settle):
            module.prepare()

    def advance(self, memory: EstimatorMemory, inputs: BlockInputs) -> EstimatedBlock:
        """Advance by the ticks of a block.

        Args:
            memory: What was remembered before them.
            inputs: What was known in them.
        """
        block = EstimatedBlock(memory, inputs, self.estimator.legs, self._memory_s)
        usual = _UsualTicks(self, block)
        for k in range(len(block)):
            if not usual.step(k):
                block.keep(k, *self.estimator.step(block.state(k), inputs.of_tick(k)))
        return block


class _UsualTicks:
    """Steps of usual ticks, in the rows of a block.

    Args:
        of: What does not change from block to block.
        block: The block.
    """

    def __init__(self, of: BlockEstimator, block: EstimatedBlock) -> None:
        estimator, inputs, rows = of.estimator, block.inputs, block.rows
        contact, settings = estimator.contact, estimator.record
        self._block, self._names = block, estimator.names
        self._error, self._no_error = estimator.kalman.error, estimator.kalman.no_error
        self._height_sd = estimator.settings.height_sd
        self._covariance = rows.reals(at.COVARIANCE)
        self._predicted = rows.reals(at.COVARIANCE_BEFORE)
        self._transition, self._noise = rows.reals(at.TRANSITION), rows.scratch(at.NOISE)
        self._stacked = of.stack[1]
        shafts_rad_s = inputs.shaft_rad_s
        if shafts_rad_s is None:
            shafts_rad_s = np.empty((0, estimator.legs))
        # what each kernel is called with in every tick
        places = shapes(estimator.legs).at
        own = (rows.real, rows.whole, rows.flags, rows.spare, places)
        feet, robot = inputs[1:3], (contact.stiffness, contact.mu, contact.anisotropy)
        self._to_predict: tuple[Any, ...] = (
            *own, *inputs[:6], *robot, design(estimator.legs), estimator.sensor_walk, settings,
        )  # fmt: skip
        nothing, least = no_answer(estimator.legs).rows.copy(), estimator.settings.force_sd**2
        self._to_expect: tuple[Any, ...] = (
            *own, *feet, contact.mu, nothing, least, settings, *of.stack,
        )  # fmt: skip
        self._to_weigh: tuple[Any, ...] = (
            of.room, rows.real, rows.whole, places, *of.stack, settings,
        )  # fmt: skip
        self._to_settle: tuple[Any, ...] = (*own, *feet, *robot, shafts_rad_s, settings, of.work)

    def step(self, k: int) -> bool:
        """Finish tick k; tell whether it is a usual one, and nothing is to be done again."""
        error = self._error
        heard = predict_kernel(k, *self._to_predict)
        if heard == UNUSUAL:
            return False
        error.x, error.P = self._no_error, self._covariance[k]
        error.F, error.Q = self._transition[k + 1], self._noise
        error.predict()
        count, made = expect_in_row_kernel(k, heard, error.P, *self._to_expect)
        counted = self._update(k, count, made) if count else NOTHING_WEIGHED
        left = settle_in_row_kernel(k, heard, counted, error.x, error.P, *self._to_settle)
        if left == UNUSUAL:
            return False
        if left & NOTABLE:
            remark = remarks(self._block.state(k), self._names)
            self._block.wordings[k + 1] = Wording(remark=remark)
        if left & ZEROS_DUE:
            self._learn_zeros(k)
        return True

    def _update(self, k: int, count: int, made: int) -> tuple[int, int, float, float]:
        """Use what passes its gate: as ``model.estimator.kalman.Kalman.update``."""
        error, rows, predicted = self._error, self._stacked[:count], self._predicted[k + 1]
        spread = rows @ predicted @ rows.T
        left, seen = np.empty(count), np.empty((count, rows.shape[1]))
        noise = np.empty((count, count))
        counted = weigh_in_row_kernel(k, count, made, spread, left, noise, seen, *self._to_weigh)
        used = counted[1]
        if used:
            error.x, error.P = self._no_error, predicted
            error.update(left[:used], noise[:used, :used], seen[:used])
        return counted

    def _learn_zeros(self, k: int) -> None:
        """Take the loads of tick k into account: ``model.estimator.shaft_zeros.learn``."""
        block, rows = self._block, self._block.rows
        heard = Heard(rows.scratch(at.HEARD), whole=True, total=np.nan, fresh=True, use=False)
        apart = Apart(rows.scratch(at.APART_VELOCITY), rows.scratch(at.APART_SHARE))
        shaft_rad_s = block.inputs.shaft_rad_s
        now = learn(
            rows.zeros(k), heard, rows.reals(at.EXPECTED)[k + 1], apart,
            block.inputs.velocity_m_s[k], None if shaft_rad_s is None else shaft_rad_s[k],
            self._height_sd * float(rows.scratch(at.ROWS)[0, HEIGHT]),
        )  # fmt: skip
        rows.lay_zeros(k + 1, now)
