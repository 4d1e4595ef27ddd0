"""A replay in blocks against one tick by tick: the same ticks, the same states, the same verdicts."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.calibration import Calibration
from model.values.input_rows import InputRows, RecordRows
from model.values.readings import ForceRecord
from record.exact_values import encode_values
from record.log.blocks.input_columns import input_rows
from record.log.blocks.tick_forms import FormBook
from record.log.reader import LogContents, TopicMessage, read_tick_messages
from record.log.tick_message import decode_inputs, encode_tick, says_the_same
from robot.config.robot_file import load_robot
from robot.control.controller import Controller
from robot.control.state_bytes import bytes_of_state
from robot.control.tick_estimator import TickEstimator
from robot.replay import blocks as replay_blocks
from robot.replay.blocks import step_in_blocks
from robot.replay.estimated import ComparedBlock
from robot.replay.step_through import step_through
from robot.run.rebuilt import rebuild_controller

BLOCK_TICKS = 100
Recorded = tuple[Path, list[TopicMessage], Controller]


@pytest.fixture(scope="module")
def recorded(short_walk: Path) -> Recorded:
    """A log, its ticks, and its controller without an estimator."""
    contents = LogContents()
    messages = list(read_tick_messages(short_walk, contents))
    controller = rebuild_controller(contents, None, None, estimate=False).controller
    return short_walk, messages, controller


@pytest.fixture(autouse=True)
def short_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a short log has several."""
    monkeypatch.setattr(replay_blocks, "BLOCK_TICKS", BLOCK_TICKS)


def rows_of(messages: Sequence[TopicMessage], controller: Controller) -> InputRows:
    data = [message.data for message in messages]
    groups = FormBook().groups(data, controller.config.parameters.names)
    rows = input_rows(len(data), [(places.tolist(), columns) for places, columns in groups])
    assert rows is not None
    return rows


def test_inputs_read_as_columns_are_those_of_each_tick(recorded: Recorded) -> None:
    _, messages, controller = recorded
    rows = rows_of(messages, controller)
    assert rows.known.sum() > 0.9 * len(messages)
    for k in np.flatnonzero(rows.known).tolist():
        alone = decode_inputs(messages[k].data)
        own = alone.inputs
        assert (rows.t_ns[k], rows.index[k], rows.ends[k]) == (alone.t_ns, alone.index, alone.end)
        assert encode_values(rows.servos.readings(k)) == encode_values(own.servos)
        wish, timing, newest = rows.request, rows.timing, rows.records
        assert (wish.intent[k], wish.gait[k]) == (own.request.intent.value, own.request.gait)
        assert wish.frequency_hz[k] == own.request.frequency_hz
        assert wish.steer[k] == own.request.steer
        assert timing.deadline_ns[k] == own.timing.deadline_ns
        assert (timing.lateness_ns[k], timing.missed[k]) == (
            own.timing.lateness_ns,
            own.timing.missed,
        )
        assert (rows.poses[k], rows.imu[k]) == (own.poses, own.imu)
        assert newest.there[k] == bool(own.forces)
        if own.forces:
            record = own.forces[-1]
            assert newest.t_ns[k] == record.t_ns
            assert newest.counts[k].tolist() == record.counts.tolist()
            assert newest.present[k].tolist() == record.present.tolist()
            assert newest.saturated[k].tolist() == record.saturated.tolist()


def test_blocks_give_the_ticks_and_the_state_of_one_tick_after_the_other(
    recorded: Recorded,
) -> None:
    path, messages, controller = recorded
    assert len(messages) > 2 * BLOCK_TICKS, "whole blocks, and one that is not"
    blocks = list(step_in_blocks(path, messages, controller, []))
    ticks = [block.tick(place) for block in blocks for place in range(len(block))]
    alone = [tick for _, _, tick in step_through(path, messages, controller, [])]
    assert list(map(encode_tick, ticks)) == list(map(encode_tick, alone))
    assert all(block.same().all() for block in blocks)
    state = controller.initial()
    for tick in alone:
        state, _ = controller.step(state, tick.inputs, tick.t_ns)
    assert bytes_of_state(blocks[-1].state) == bytes_of_state(state)


def test_every_byte_counts(recorded: Recorded) -> None:
    """Outputs changed here and there in the log, numbers, texts, lengths and padding."""
    path, messages, controller = recorded
    draw, changed = np.random.default_rng(3), []
    for message in messages[: 2 * BLOCK_TICKS]:
        data = bytearray(message.data)
        if draw.random() < 0.6:
            end = decode_inputs(message.data).end
            data[int(draw.integers(end + 4, len(data)))] ^= 1 << int(draw.integers(0, 8))
        changed.append(replace(message, data=bytes(data)))
    for estimator in (TickEstimator(controller.config), None):
        verdicts: list[bool] = []
        for block in step_in_blocks(path, changed, controller, []):
            compared = ComparedBlock(block, estimator)
            for estimate, same in ((False, block.same()), (True, compared.same())):
                if estimate and estimator is None:
                    assert not same.any(), "the log has estimates"
                    continue
                expected = [
                    says_the_same(
                        compared.tick(place), message.data, block.recorded(place).end,
                        estimate=estimate,
                    )
                    for place, message in enumerate(block.messages)
                ]  # fmt: skip
                assert same.tolist() == expected
                verdicts += expected
        assert set(verdicts) == {True, False}


def test_a_gap_ends_it_where_it_ends_a_replay_tick_by_tick(recorded: Recorded) -> None:
    path, messages, controller = recorded
    for gap in (BLOCK_TICKS, BLOCK_TICKS + 40, 2 * BLOCK_TICKS + 20):
        holed, notes, other = [*messages[:gap], *messages[gap + 3 :]], list[str](), list[str]()
        blocks = list(step_in_blocks(path, holed, controller, notes))
        assert sum(map(len, blocks)) == gap
        assert len(list(step_through(path, holed, controller, other))) == gap
        assert all(block.same().all() for block in blocks)
        assert notes == other


def test_forces_of_many_records_are_those_of_each(recorded: Recorded) -> None:
    """Also of transducers that are missing, saturated, or not calibrated, and in ticks without a record."""
    _, messages, _ = recorded
    config = load_robot()
    known = Calibration(1, "", "", "", 3.7e4, 1.1e5, True, (np.nan,) * 6)
    controller = Controller(config, (known, None, known, known, known, known), armed=False)
    draw, records = np.random.default_rng(5), list[ForceRecord]()
    for message in messages:
        for one in decode_inputs(message.data).inputs.forces:
            present, saturated = draw.random(6) < 0.9, draw.random(6) < 0.1
            records.append(replace(one, present=present, saturated=saturated))
    records, there = records[:100], draw.random(100) < 0.8
    rows = RecordRows(
        there,
        *(
            np.array([getattr(one, name) for one in records])
            for name in ("t_ns", "counts", "present", "saturated")
        ),
    )
    scales, newest = controller.scales, controller.initial().senses.forces
    together = scales.rows(rows, np.zeros((100, 6)), newest)
    for k, record in enumerate(records):
        if there[k]:
            newest = scales.forces(record, np.zeros(6))
        assert encode_values(together.forces(k)) == encode_values(newest)
