"""A replay in blocks against one tick by tick: the same ticks, the same states, the same verdicts."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.calibration import Calibration
from model.values.faults import FaultKind, ServoEvent
from model.values.readings import ForceRecord
from model.values.tick import Inputs, Tick
from record.exact_values import encode_values
from record.log.blocks.tick_forms import FormBook
from record.log.blocks.tick_inputs import inputs_of
from record.log.reader import LogContents, TopicMessage, read_tick_messages
from record.log.tick_message import decode_inputs, encode_tick, says_the_same
from robot.config.robot_file import load_robot
from robot.control.ahead import Ahead
from robot.control.controller import Controller
from robot.control.state_bytes import bytes_of_state
from robot.replay.blocks import BLOCK_TICKS, step_in_blocks
from robot.replay.step_through import step_through
from robot.run.rebuilt import rebuild_controller


@pytest.fixture(scope="module")
def recorded(short_walk: Path) -> tuple[Path, list[TopicMessage], Controller]:
    contents = LogContents()
    messages = list(read_tick_messages(short_walk, contents))
    return short_walk, messages, rebuild_controller(contents, None, None).controller


def test_inputs_read_as_columns_are_those_of_each_tick(
    recorded: tuple[Path, list[TopicMessage], Controller],
) -> None:
    _, messages, controller = recorded
    data, found = [message.data for message in messages], 0
    for places, columns in FormBook().groups(data, controller.config.parameters.names):
        for place, one in zip(places.tolist(), inputs_of(columns) or (), strict=False):
            alone = decode_inputs(data[place])
            assert (one.t_ns, one.index, one.end) == (alone.t_ns, alone.index, alone.end)
            assert encode_values(one.inputs) == encode_values(alone.inputs)
            found += 1
    assert found > 0.9 * len(messages)


def test_blocks_give_the_ticks_and_the_state_of_one_tick_after_the_other(
    recorded: tuple[Path, list[TopicMessage], Controller],
) -> None:
    path, messages, controller = recorded
    assert len(messages) > 2 * BLOCK_TICKS, "whole blocks, and one that is not"
    blocks = list(step_in_blocks(path, messages, controller, []))
    ticks = [tick for block in blocks for tick in block.ticks]
    alone = [tick for _, _, tick in step_through(path, messages, controller, [])]
    assert list(map(encode_tick, ticks)) == list(map(encode_tick, alone))
    assert all(alike for block in blocks for alike in block.same())
    state = controller.initial()
    for tick in alone:
        state, _ = controller.step(state, tick.inputs, tick.t_ns)
    assert bytes_of_state(blocks[-1].state) == bytes_of_state(state)


def test_every_byte_counts(recorded: tuple[Path, list[TopicMessage], Controller]) -> None:
    """Outputs changed here and there in the log, numbers, texts, lengths and padding."""
    path, messages, controller = recorded
    draw, changed = np.random.default_rng(3), []
    for message in messages[: 2 * BLOCK_TICKS]:
        data = bytearray(message.data)
        if draw.random() < 0.6:
            end = decode_inputs(message.data).end
            data[int(draw.integers(end + 4, len(data)))] ^= 1 << int(draw.integers(0, 8))
        changed.append(replace(message, data=bytes(data)))
    for estimate in (True, False):
        verdicts: list[bool] = []
        for block in step_in_blocks(path, changed, controller, []):
            alike = block.same(estimate=estimate)
            told = zip(block.ticks, block.messages, block.recorded, strict=True)
            assert alike == [
                says_the_same(tick, message.data, given.end, estimate=estimate)
                for tick, message, given in told
            ]
            verdicts += alike
        assert set(verdicts) == {True, False}


def test_a_gap_ends_it_where_it_ends_a_replay_tick_by_tick(
    recorded: tuple[Path, list[TopicMessage], Controller],
) -> None:
    path, messages, controller = recorded
    for gap in (BLOCK_TICKS, BLOCK_TICKS + 40):
        holed, notes, other = [*messages[:gap], *messages[gap + 3 :]], list[str](), list[str]()
        blocks = list(step_in_blocks(path, holed, controller, notes))
        ticks = [tick for block in blocks for tick in block.ticks]
        assert len(ticks) == gap == len(list(step_through(path, holed, controller, other)))
        assert all(alike for block in blocks for alike in block.same())
        assert notes == other


def stepped(
    controller: Controller, inputs: Sequence[Inputs], times: Sequence[int], block: int
) -> tuple[list[Tick], bytes, int]:
    """Ticks and state, and how many ticks took what was computed beforehand; ``block`` 0 for none."""
    state, ticks, used = controller.initial(), list[Tick](), 0
    known: list[Ahead] = []
    begin = 0
    for i, (own, t_ns) in enumerate(zip(inputs, times, strict=True)):
        if block and i % block == 0:
            begin, known = i, controller.ahead(state, inputs[i : i + block], times[i : i + block])
        one = known[i - begin] if i - begin < len(known) else None
        state, tick = controller.step(state, own, t_ns, one)
        used += one is not None and tick.joints is one.joints
        ticks.append(tick)
    return ticks, bytes_of_state(state), used


def test_what_is_computed_beforehand_changes_nothing_whatever_servos_do(
    recorded: tuple[Path, list[TopicMessage], Controller],
) -> None:
    _, messages, controller = recorded
    given = [decode_inputs(message.data) for message in messages[:400]]
    inputs, times = [one.inputs for one in given], [one.t_ns for one in given]
    for i, own in enumerate(inputs):
        servos = own.servos
        assert servos is not None
        if i % 23 == 5:  # one does not answer
            valid = servos.valid.copy()
            valid[i % 6] = False
            inputs[i] = replace(own, servos=replace(servos, valid=valid))
        elif i == 150:  # one loses its torque, and is brought back
            inputs[i] = replace(own, servo_events=(ServoEvent(2, FaultKind.SERVO_DOWN),))
        elif i == 190:
            inputs[i] = replace(own, servo_events=(ServoEvent(2, FaultKind.SERVO_RECOVERED),))
        elif i == 260:
            inputs[i] = replace(own, servos=None)
        elif i % 31 == 7:
            inputs[i] = replace(own, forces=())
    alone, state, none = stepped(controller, inputs, times, 0)
    assert none == 0
    for block in (32, 50):
        ticks, own_state, used = stepped(controller, inputs, times, block)
        assert used > 200
        assert list(map(encode_tick, ticks)) == list(map(encode_tick, alone))
        assert own_state == state


def test_forces_of_many_records_are_those_of_each(
    recorded: tuple[Path, list[TopicMessage], Controller],
) -> None:
    """Also of transducers that are missing, saturated, or not calibrated."""
    _, messages, _ = recorded
    config = load_robot()
    known = Calibration(1, "", "", "", 3.7e4, 1.1e5, True, (np.nan,) * 6)
    controller = Controller(config, (known, None, known, known, known, known), armed=False)
    draw, records = np.random.default_rng(5), list[tuple[ForceRecord, ...]]()
    for message in messages:
        for one in decode_inputs(message.data).inputs.forces:
            present, saturated = draw.random(6) < 0.9, draw.random(6) < 0.1
            records.append((replace(one, present=present, saturated=saturated),))
    records = [*records[:100], ()]
    together = controller._scales.of_newest(records)
    assert together.pop() is None
    for found, (record,) in zip(together, records[:100], strict=True):
        assert found is not None
        alone = controller._scales.forces(record, np.zeros(6))
        assert encode_values(found) == encode_values(alone)
