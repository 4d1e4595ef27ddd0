"""Ticks of a walk stepped in rows: what the step makes of them, whatever happens in between."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from model.values.faults import Fault, FaultKind, StopReason
from model.values.readings import ServoReadings
from model.values.tick import Inputs, Intent, Mode, Tick
from record.log.reader import LogContents, TopicMessage, read_tick_messages
from record.log.tick_message import decode_tick, encode_tick
from robot.control.controller import Controller
from robot.control.state_bytes import bytes_of_state
from robot.replay.blocks import step_in_blocks
from robot.replay.outputs import WalkedPart
from robot.replay.step_through import in_order, step_recorded
from robot.run.rebuilt import rebuild_controller

Change = Callable[[Inputs, int], Inputs]
TICKS = 400
AT = 240  # a tick of the walk, which begins with tick 88
Walk = tuple[Path, list[TopicMessage], list[Tick], Controller]


@pytest.fixture(scope="module")
def walked(cycle_walk: Path) -> Walk:
    """A log, the first ticks of it as messages and as ticks, and a controller without an estimator."""
    contents = LogContents()
    messages = list(islice(read_tick_messages(cycle_walk, contents), TICKS))
    return (
        cycle_walk,
        messages,
        [decode_tick(message.data) for message in messages],
        rebuild_controller(contents, None, None, estimate=False).controller,
    )


def changed(
    messages: Sequence[TopicMessage], ticks: Sequence[Tick], change: Change
) -> list[TopicMessage]:
    """Messages with other inputs."""
    others = []
    for k, (message, tick) in enumerate(zip(messages, ticks, strict=True)):
        inputs = change(tick.inputs, k - AT)
        data = message.data
        if inputs is not tick.inputs:
            data = encode_tick(replace(tick, inputs=inputs))
        others.append(replace(message, data=data))
    return others


def in_rows_and_alone(walk: Walk, change: Change) -> tuple[int, set[str], Mode, StopReason]:
    """Step both ways, which must come to the same; say how many ticks were in rows, and what came of it."""
    path, whole, ticks, controller = walk
    messages = changed(whole, ticks, change)
    blocks = list(step_in_blocks(path, messages, controller, []))
    state, faults, place, in_rows = controller.initial(), set[str](), 0, 0
    one_by_one = in_order(path, messages, [])
    for block in blocks:
        in_rows += sum(len(part) for part in block.parts if isinstance(part, WalkedPart))
        for own in range(len(block)):
            message, recorded = next(one_by_one)
            state, tick = step_recorded(path, message, recorded, controller, state)
            assert encode_tick(block.tick(own)) == encode_tick(tick), place
            faults |= {fault.kind.name for fault in tick.faults}
            place += 1
        assert bytes_of_state(block.state) == bytes_of_state(state), place
    assert place == TICKS
    return in_rows, faults, tick.mode, tick.stop_reason


def of_servos(change: Callable[[ServoReadings, int], ServoReadings]) -> Change:
    def changing(inputs: Inputs, k: int) -> Inputs:
        assert inputs.servos is not None
        return replace(inputs, servos=change(inputs.servos, k))

    return changing


def with_leg(values: np.ndarray, value: float | bool, leg: int = 2) -> np.ndarray:
    other = values.copy()
    other[leg] = value
    return other


def test_a_walk_in_which_nothing_happens(walked: Walk) -> None:
    in_rows, faults, mode, _ = in_rows_and_alone(walked, lambda inputs, _: inputs)
    assert (faults, mode) == (set(), Mode.WALK)
    assert in_rows > 300


@pytest.mark.parametrize(
    ("field", "value", "ticks", "fault"),
    [
        ("valid", False, 1, FaultKind.SERVO_SILENT),
        pytest.param("error_byte", 0x80, 1, FaultKind.SERVO_ALERT, marks=pytest.mark.soak),
        ("hardware_error", 4, 1, FaultKind.SERVO_ALERT),
        ("temperature_c", 99, 2, FaultKind.SERVO_HOT),
        ("current_counts", 2000, 2, FaultKind.SERVO_CURRENT),
        pytest.param("voltage_counts", 60, 2, FaultKind.SERVO_VOLTAGE, marks=pytest.mark.soak),
        ("position_ticks", 9000, 2, FaultKind.SERVO_LAG),
        ("position_ticks", 255 * 4096, 1, FaultKind.TURNS_USED),
    ],
)
def test_a_servo_beyond_a_limit(
    walked: Walk, field: str, value: float, ticks: int, fault: FaultKind
) -> None:
    def beyond(servos: ServoReadings, k: int) -> ServoReadings:
        if not 0 <= k < ticks:
            return servos
        return replace(servos, **{field: with_leg(getattr(servos, field), value)})  # type: ignore[arg-type]

    in_rows, faults, _, _ = in_rows_and_alone(walked, of_servos(beyond))
    assert fault.name in faults
    assert in_rows > 100


def test_a_shaft_that_stands_still_against_a_load(walked: Walk) -> None:
    held: list[int] = []

    def stalls(servos: ServoReadings, k: int) -> ServoReadings:
        if k < 0:
            return servos
        held.append(int(servos.position_ticks[2]))
        return replace(
            servos, position_ticks=with_leg(servos.position_ticks, held[0]),
            current_counts=with_leg(servos.current_counts, 1400),
        )  # fmt: skip

    _, faults, mode, reason = in_rows_and_alone(walked, of_servos(stalls))
    assert {"SERVO_STALLED", "SERVO_LAG"} & faults
    assert (mode is Mode.WALK) == (reason is StopReason.NONE)
    assert reason is not StopReason.NONE


def test_forces_that_are_silent_and_come_back(walked: Walk) -> None:
    def silent(inputs: Inputs, k: int) -> Inputs:
        return replace(inputs, forces=()) if 0 <= k < 80 or k % 7 == 0 else inputs

    in_rows, _, mode, _ = in_rows_and_alone(walked, silent)
    assert mode is Mode.WALK
    assert in_rows > 200


@pytest.mark.parametrize(("axis", "factor", "fault"), [(2, 0.02, "UNLOADED"), (0, 9.0, "TILTED")])
def test_forces_of_a_robot_that_hangs_or_leans(
    walked: Walk, axis: int, factor: float, fault: str
) -> None:
    def other(inputs: Inputs, k: int) -> Inputs:
        if k < 0 or not inputs.forces:
            return inputs
        record = inputs.forces[-1]
        counts = record.counts.copy()
        counts[:, axis] = factor * counts[:, 2]
        return replace(inputs, forces=(*inputs.forces[:-1], replace(record, counts=counts)))

    _, faults, _, reason = in_rows_and_alone(walked, other)
    assert fault in faults
    assert reason.name == fault


@pytest.mark.parametrize(
    ("lateness_ms", "missed"),
    [
        pytest.param(30, 0, marks=pytest.mark.soak),
        (0, 2),
        pytest.param(0, 7, marks=pytest.mark.soak),
        (40, 3),
    ],
)
def test_a_loop_that_is_late_or_stands_still(walked: Walk, lateness_ms: int, missed: int) -> None:
    def late(inputs: Inputs, k: int) -> Inputs:
        if k % 90:
            return inputs
        timing = replace(inputs.timing, lateness_ns=lateness_ms * 1_000_000, missed=missed)
        return replace(inputs, timing=timing)

    in_rows, faults, _, _ = in_rows_and_alone(walked, late)
    assert ("LATE" in faults) == (lateness_ms > 0 or missed > 4)
    assert in_rows > 100


@pytest.mark.parametrize(
    "wish",
    [
        {"frequency_hz": 0.29},
        pytest.param({"steer": 0.6}, marks=pytest.mark.soak),
        {"frequency_hz": 99.0},
        {"gait": "nobody's"},
        pytest.param({"intent": Intent.STAND}, marks=pytest.mark.soak),
        {"intent": Intent.STOP, "reason": StopReason.OPERATOR},
        {"intent": Intent.CUT, "reason": StopReason.EMERGENCY},
    ],
    ids=lambda wish: "-".join(wish),
)
def test_another_wish(walked: Walk, wish: dict[str, object]) -> None:
    def wished(inputs: Inputs, k: int) -> Inputs:
        return inputs if k < 0 else replace(inputs, request=replace(inputs.request, **wish))  # type: ignore[arg-type]

    in_rows, _, mode, _ = in_rows_and_alone(walked, wished)
    assert (mode is Mode.WALK) == (
        set(wish) <= {"frequency_hz", "steer"} and 99.0 not in wish.values()
    )
    assert in_rows > 100


def test_ticks_that_hold_no_servos_or_a_fault_of_a_driver(walked: Walk) -> None:
    def odd(inputs: Inputs, k: int) -> Inputs:
        if k in {3, 4}:
            return replace(inputs, servos=None)
        if k == 60:
            gap = Fault(FaultKind.FORCE_GAP, "force unit", "3 samples are missing")
            return replace(inputs, faults=(gap,))
        return inputs

    in_rows, faults, _, _ = in_rows_and_alone(walked, odd)
    assert {"SERVO_SILENT", "FORCE_GAP"} <= faults
    assert in_rows > 200
