"""Answers taken apart at once, and reads calibrated at once, are those of plain Python."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.answers_kernel import loop_reader
from drivers.dynamixel.catalog import MX_106, READ_LENGTH
from drivers.dynamixel.frames import build_status
from drivers.dynamixel.joints import ReadCalibration, joint_state
from drivers.dynamixel.loop_registers import loop_columns
from drivers.dynamixel.packets import answers_in_order
from drivers.dynamixel.settings import ServoBusSettings
from model.values.readings import ServoReadings
from tests.drivers.test_servo_cycle import Rig

LEGS = 6
SETTINGS = ServoBusSettings(
    names=("HL", "ML", "FL", "HR", "MR", "FR"),
    ids=np.arange(1, 1 + LEGS),
    signs=np.array([1, 1, 1, -1, -1, -1]),
    zeros=np.array([2048, -7, 0, 4095, 100_000, 2048]),
    models=(MX_106,) * LEGS,
    baud_rate=1_000_000,
    watchdog_s=0.24,
    silent_limit=5,
)
PARAMETERS = st.binary(min_size=READ_LENGTH, max_size=READ_LENGTH)


@given(
    st.lists(st.integers(0, 252), min_size=1, max_size=7, unique=True),
    st.sampled_from([0, 0, 0, 0x80, 0x80, 1, 0x83]),
    st.data(),
)
def test_they_are_those_of_one_by_one(ids: list[int], error: int, data: st.DataObject) -> None:
    """Also with a bit that fell over somewhere, or an answer too many or too few."""
    frames = [build_status(i, error, data.draw(PARAMETERS)) for i in ids]
    if data.draw(st.booleans()):
        frames = frames[: data.draw(st.integers(0, len(frames)))] + frames[:1]
    raw = bytearray(b"".join(frames))
    if data.draw(st.booleans()):
        raw[data.draw(st.integers(0, len(raw) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    at_once = loop_reader(ids)(bytes(raw))
    answers = answers_in_order(bytes(ids), READ_LENGTH, bytes(raw))
    if answers is None:
        assert at_once is None
        return
    assert at_once is not None
    assert not at_once.flags.writeable
    np.testing.assert_array_equal(at_once[0], [answer.error for answer in answers])
    np.testing.assert_array_equal(at_once[1:], loop_columns(answers))


def test_nothing_is_no_answer() -> None:
    assert loop_reader([1, 2])(b"") is None


def _same(one: object, other: object) -> None:
    assert type(one) is type(other)
    for field in fields(one):  # type: ignore[arg-type]
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


@pytest.mark.parametrize("silent", [None, 3])
@pytest.mark.parametrize("alert", [False, True])
def test_a_prepared_bus_reads_the_same(silent: int | None, *, alert: bool) -> None:
    """Read by read, with a servo that is silent at times and one whose alert is on."""
    plain, prepared = Rig(present_position=-77), Rig(present_position=-77)
    prepared.bus.prepare()
    for number in range(24):
        reads = []
        for rig in (plain, prepared):
            rig.servo(2).alert = alert and number > 4
            if silent is not None:
                rig.servo(silent).silent = number % 5 == 3
            rig.servo(4).values["present_position"] = 1_000 * number
            rig.servo(5).values["present_velocity"] = -number
            reads.append(rig.bus.read())
        _same(*reads)
        assert plain.bus.stats == prepared.bus.stats
    assert plain.polled() == prepared.polled()


@given(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=LEGS, max_size=LEGS))
def test_a_read_calibrated_at_once_is_the_same(seed: int, valid: list[bool]) -> None:
    random = np.random.default_rng(seed)
    counts = random.integers(-(2**31), 2**31, (6, LEGS))
    age = np.zeros(LEGS, dtype=np.int64)
    position, velocity, current, duty, voltage, temperature = counts
    readings = ServoReadings(
        7, position, velocity, current, duty, voltage, temperature, age, age, np.array(valid), age
    )
    _same(ReadCalibration(SETTINGS).state(readings), joint_state(readings, SETTINGS))
