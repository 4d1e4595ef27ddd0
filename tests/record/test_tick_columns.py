"""Ticks read as columns are the ticks taken apart one by one, in every bit, whatever is in them."""

import random
from collections.abc import Sequence
from itertools import starmap
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Schema

from model.values.machine_names import MachineNames, one_joint_a_leg
from model.values.tick import SensedTick, Tick
from record.log.blocks.message_form import form_of
from record.log.blocks.read import read_blocks, read_log
from record.log.blocks.tick_columns import StackedTicks, stack_messages
from record.log.blocks.tick_forms import TICK, FormBook
from record.log.definitions import DEFINITIONS
from record.log.reader import LogContents, TopicMessage, read_stamped_ticks, read_tick_messages
from record.log.recording import STACKS, build_recording, standard_deviations, thin_recording
from record.log.tick_message import TICK_DEFINITIONS, decode_tick, encode_tick
from tests.record.test_log import same
from tests.record.ticks import make_tick

SCHEMA = Schema(
    data=DEFINITIONS["bigant_msgs/msg/Tick"].encode(), encoding="ros2msg", id=1, name=TICK
)


def messages_of(data: Sequence[bytes]) -> list[TopicMessage]:
    return [TopicMessage("/tick", SCHEMA, i, i, one) for i, one in enumerate(data)]


def names_of(legs: int) -> MachineNames:
    return one_joint_a_leg(tuple(f"L{i}" for i in range(legs)))


def must_be(stacked: StackedTicks, ticks: Sequence[Tick], machine: MachineNames) -> None:
    """Compare with the same ticks taken apart."""
    expected = build_recording(
        ticks, machine=machine, start_ns=0, config_text="", metadata={}, damage=""
    )
    for name in STACKS:
        own, theirs = stacked.arrays[name], getattr(expected, name)
        assert (own.dtype, own.shape) == (theirs.dtype, theirs.shape), name
        np.testing.assert_array_equal(own, theirs, err_msg=name)
    assert stacked.faults == expected.faults
    sensed = tuple(stacked.sensed) if stacked.sensed is not None else ()
    assert same(sensed, tuple(tick.sensed for tick in ticks))


@given(st.lists(st.integers(0, 12), min_size=1, max_size=40), st.integers(2, 9))
def test_columns_are_the_ticks(indices: list[int], legs: int) -> None:
    ticks = [make_tick(index, legs=legs, seed=number) for number, index in enumerate(indices)]
    data, machine = list(map(encode_tick, ticks)), names_of(legs)
    stacked = stack_messages(messages_of(data), machine, FormBook(), with_sensed=True)
    assert stacked.kept.all()
    must_be(stacked, [decode_tick(one) for one in data], machine)


@pytest.mark.parametrize("value", [7, 255])
def test_a_tick_with_any_byte_damaged_is_read_or_refused(value: int) -> None:
    whole = encode_tick(make_tick(2, seed=5))
    refused = 0
    for at in range(len(whole)):
        one = whole[:at] + bytes([value]) + whole[at + 1 :]
        try:
            decode_tick(one)
        except (ValueError, OverflowError, MemoryError):
            refused += 1
    assert 5 < refused < len(whole) / 2


@given(st.randoms(use_true_random=False))
def test_of_damaged_ticks_the_same_are_kept(dice: random.Random) -> None:
    whole = [encode_tick(make_tick(index % 4, seed=index)) for index in range(24)]
    damaged = []
    for one in whole:
        data = bytearray(
            one if dice.random() < 0.9 else one[: dice.choice((0, dice.randrange(len(one))))]
        )
        for _ in range(dice.randrange(2) if data else 0):
            data[dice.randrange(len(data))] = dice.randrange(256)
        damaged.append(bytes(data))
    readable: list[Tick] = []
    lost = []
    for place, one in enumerate(damaged):
        try:
            tick = decode_tick(one)
        except (ValueError, OverflowError, MemoryError):
            lost.append(place)
            continue
        if len(tick.joints.angle_rad) != 6 or len(tick.forces.force_n) != 6:
            return  # a table has one width: such a log cannot be stacked at all, as before
        readable.append(tick)
    machine = names_of(6)
    try:
        for stack in STACKS.values():
            stack.of(readable, 6, 6)
    except ValueError:
        return  # likewise, of another field
    stacked = stack_messages(messages_of(damaged), machine, FormBook(), with_sensed=True)
    assert [place for place, _ in stacked.broken] == lost
    assert np.flatnonzero(~stacked.kept).tolist() == lost
    must_be(stacked, readable, machine)


def test_a_negative_variance_has_no_standard_deviation() -> None:
    """Of damaged bytes; the others of the tick are kept, and nothing is printed."""
    covariance = np.diag([4.0, 9.0, -8.3e-308])
    assert standard_deviations(covariance) == pytest.approx([2.0, 3.0, np.nan], nan_ok=True)
    both = standard_deviations(np.stack([covariance, np.eye(3)]))
    assert both == pytest.approx(np.array([[2.0, 3.0, np.nan], [1.0, 1.0, 1.0]]), nan_ok=True)


def test_a_log_read_in_blocks_is_the_log(short_walk: Path) -> None:
    contents = LogContents()
    stamped = list(read_stamped_ticks(short_walk, contents))
    ticks = [item.tick for item in stamped]
    seen: list[tuple[int, SensedTick]] = []
    log = read_log(short_walk, None, lambda times, own: seen.extend(zip(times, own, strict=True)))
    begin = contents.start_unix_ns(0)
    expected = build_recording(
        ticks,
        machine=contents.machine(ticks[0]),
        start_ns=0,
        times_s=[(item.unix_ns - begin) * 1e-9 for item in stamped],
        config_text=contents.config_text,
        metadata=contents.metadata,
        damage="",
    )
    assert same(log, expected)
    assert same(tuple(seen), tuple((item.unix_ns, item.tick.sensed) for item in stamped))
    small = list(read_blocks(short_walk, block_ticks=97))
    assert [len(block.t_s) for block in small[:-1]] == [97] * (len(small) - 1)
    np.testing.assert_array_equal(np.concatenate([one.angle_rad for one in small]), log.angle_rad)


def test_nearly_every_tick_of_a_walk_is_read_as_a_column(cycle_walk: Path) -> None:
    contents = LogContents()
    messages = list(read_tick_messages(cycle_walk, contents))
    machine = contents.machine(decode_tick(messages[0].data))
    groups = FormBook().groups([one.data for one in messages], machine)
    places = np.concatenate([place for place, _ in groups])
    assert len(set(places.tolist())) == len(places)
    assert len(places) > 0.98 * len(messages)


def test_two_ticks_of_one_form_have_every_field_in_one_place() -> None:
    one, other = (encode_tick(make_tick(7, seed=seed)) for seed in (1, 2))
    forms = list(starmap(form_of, ((one, TICK_DEFINITIONS, TICK), (other, TICK_DEFINITIONS, TICK))))
    assert forms[0].places == forms[1].places
    assert forms[0].counts == {
        "force_records": 1, "input_faults": 1, "pose_records": 1, "imu_records": 2, "faults": 1,
        "estimate": 1,
    }  # fmt: skip
    table = np.frombuffer(one + other + encode_tick(make_tick(8, seed=1))[: len(one)], np.uint8)
    rows = table[: 2 * len(one)].reshape(2, -1)
    assert forms[0].fits(rows).all()


def test_a_thinned_recording_holds_nothing_of_what_is_left_out(cycle_walk: Path) -> None:
    log = read_log(cycle_walk)
    thin = thin_recording(log, 8)
    assert thin.angle_rad.base is None
    np.testing.assert_array_equal(thin.angle_rad, log.angle_rad[::8])
