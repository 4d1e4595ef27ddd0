"""Who on the servo bus hears a request, and what all of them answer to a read of what they measure.

Both follow from registers that hardly ever change, so they are worked out once and kept for as long as
those registers stay. What is out of the ordinary (an id that two servos share, a read beyond what is
measured, a number that does not fit its register) is left to the bus, servo by servo.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import gt
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.frames import LARGEST_ID, STATUS_BYTES
from model.values.arrays import FloatArray, IntArray
from sim_hw.dynamixel import measured_kernel
from sim_hw.dynamixel.control_table import measured_run
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.servo import VirtualServo, realtime_tick
from sim_hw.interfaces import MotorReadings

KEPT_REQUESTS = 8  # a host asks for the same few things again and again
GOAL_BYTES = 4


class Listeners:
    """The servos that understand what is on the wire, as their registers are now.

    Args:
        every: All servos of the bus.
        baud_code: Value of the baud rate register that goes with what is on the wire, None for no such.
        t_ns: Now.
        silent: Ids that are off the wire.

    Attributes:
        servos: Those that listen, in the world's order.
        by_id: The same by their ids.
        shadows: Those of them with a secondary id.
    """

    def __init__(
        self,
        every: Sequence[VirtualServo],
        baud_code: int | None,
        t_ns: int,
        silent: Mapping[int, bool],
    ) -> None:
        self.every, self._baud_code = every, baud_code
        self._changes = [servo.table.changes for servo in every]
        self._awake = all(servo.awake(t_ns) for servo in every)
        self.servos = [
            s for s in every if s.understands(baud_code, t_ns) and s.servo_id not in silent
        ]
        self.by_id: dict[int, tuple[VirtualServo, ...]] = defaultdict(tuple)
        for servo in self.servos:
            self.by_id[servo.servo_id] += (servo,)
        self.shadows = [servo for servo in self.servos if servo.shadow_id <= LARGEST_ID]
        self._reads: dict[bytes, MeasuredRead | None] = {}
        self._goals: dict[bytes, GoalWrite | None] = {}

    def hold(self, baud_code: int | None) -> bool:
        """Whether they are still those, at a later time."""
        same = baud_code == self._baud_code and self._awake
        return same and self._changes == [servo.table.changes for servo in self.every]

    def measured_read(self, parameters: bytes) -> "MeasuredRead | None":
        """Return how a sync read with these parameters is answered at once; None if it is not."""
        if parameters not in self._reads:
            if len(self._reads) >= KEPT_REQUESTS:
                self._reads.clear()
            self._reads[parameters] = _measured_read(self, parameters)
        return self._reads[parameters]

    def goal_write(self, parameters: bytes) -> "GoalWrite | None":
        """Return how a sync write with these parameters is done at once; None if it is not."""
        key = parameters[:4] + parameters[4 :: 1 + GOAL_BYTES]
        if key not in self._goals:
            if len(self._goals) >= KEPT_REQUESTS:
                self._goals.clear()
            self._goals[key] = _goal_write(self, parameters)
        return self._goals[key]


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredRead:
    """A sync read of measured registers from servos that each answer alone.

    Attributes:
        ids: Ids, in the order of the answers.
        delays_ns: Return delay of each.
        begin: First byte, counted from the first measured one.
        length: Bytes of each servo.
        who: Index of each, (M,).
        numbers: ``ids`` as an array, (M,).
        settings: A row for each servo of the bus, (N, 5); see ``measured_kernel``.
        bounds: Least and largest value of each measured register, (R, 2).
        sizes: Their bytes, (R,).
        data: Room for the answers.
        ends: Room for where each of them ends, (M,).
    """

    ids: tuple[int, ...]
    delays_ns: tuple[int, ...]
    begin: int
    length: int
    who: IntArray
    numbers: IntArray
    settings: FloatArray
    bounds: FloatArray
    sizes: IntArray
    data: NDArray[np.uint8]
    ends: IntArray

    def answers(self, loops: Any, motors: MotorReadings, t_ns: int) -> list[bytes] | None:
        """Return the frames of all answers; None where a number does not fit its register.

        Args:
            loops: Records of the firmware, (N,).
            motors: What the sensors give now.
            t_ns: Now.
        """
        if not measured_kernel.measured_answers(
            loops, self.who, self.numbers, self.settings, *motors, realtime_tick(t_ns),
            self.bounds, self.sizes, self.begin, self.length, self.data, self.ends,
        ):  # fmt: skip
            return None
        ends = self.ends.tolist()
        data = self.data[: ends[-1]].tobytes()
        return [data[at:end] for at, end in zip([0, *ends], ends, strict=False)]


def _measured_read(listeners: Listeners, parameters: bytes) -> MeasuredRead | None:
    address, length = (int.from_bytes(parameters[at : at + 2], "little") for at in (0, 2))
    ids, every = tuple(parameters[4:]), listeners.every
    alone = [listeners.by_id.get(servo_id, ()) for servo_id in ids]
    if not ids or any(len(servos) != 1 for servos in alone):
        return None
    answering = [servos[0] for servos in alone]
    run, *others = [measured_run(servo.table.model) for servo in every]
    begin = address - run.address
    if begin < 0 or not 0 < length <= run.layout.size - begin:
        return None
    if any((one.address, one.layout.format) != (run.address, run.layout.format) for one in others):
        return None
    if any(servo.table.values["status_return_level"] < 1 for servo in answering):
        return None
    return MeasuredRead(
        ids=ids,
        delays_ns=tuple(servo.return_delay_ns for servo in answering),
        begin=begin,
        length=length,
        who=np.array([every.index(servo) for servo in answering]),
        numbers=np.array(ids),
        settings=np.array([servo.measured_settings() for servo in every], dtype=np.float64),
        bounds=run.bounds,
        sizes=run.sizes,
        data=np.zeros(len(ids) * (STATUS_BYTES + 2 * length), dtype=np.uint8),
        ends=np.zeros(len(ids), dtype=np.int64),
    )


@dataclass(frozen=True, slots=True, eq=False)
class GoalWrite:
    """A sync write of goal positions to servos that each have an id of their own.

    Attributes:
        servos: The servos, in the order of the request.
        layout: Of the parameters.
        least: Least goal that each of them takes.
        most: Largest goal.
        who: Index of each; a slice where all are asked in the world's order.
        mounting: Sense and offset [ticks] of each; see ``VirtualServo.plain_goal``.
    """

    servos: tuple[VirtualServo, ...]
    layout: Struct
    least: tuple[int, ...]
    most: tuple[int, ...]
    who: list[int] | slice
    mounting: tuple[tuple[int, int], ...]

    def done(self, parameters: bytes, firmware: FirmwareBank) -> bool:
        """Give all servos their goals.

        Args:
            parameters: Of the sync write.
            firmware: The loops that the goals go to.

        Returns:
            False, and nothing is done, where one of them does not take its goal as it is.
        """
        goals = self.layout.unpack(parameters)[3::2]
        if any(map(gt, self.least, goals)) or any(map(gt, goals, self.most)):
            return False
        if not firmware.all_follow:
            return False
        first = 5
        for servo, goal in zip(self.servos, goals, strict=True):
            servo.table.put_goal(goal, parameters[first : first + GOAL_BYTES])
            first += 1 + GOAL_BYTES
        # half a dozen are put there sooner as a list than as an array
        firmware.goal_position[self.who] = [
            sense * (goal - offset)
            for goal, (sense, offset) in zip(goals, self.mounting, strict=True)
        ]
        return True


def _goal_write(listeners: Listeners, parameters: bytes) -> GoalWrite | None:
    ids = parameters[4 :: 1 + GOAL_BYTES]
    layout = Struct("<HH" + "Bi" * len(ids))
    alone = [listeners.by_id.get(servo_id, ()) for servo_id in ids]
    if not ids or layout.size != len(parameters) or any(len(servos) != 1 for servos in alone):
        return None
    address, length = (int.from_bytes(parameters[at : at + 2], "little") for at in (0, 2))
    goal = COMMON["goal_position"]
    if (address, length) != (goal.address, GOAL_BYTES) or listeners.shadows:
        return None
    writing = tuple(servos[0] for servos in alone)
    registers = [servo.table.model.table["goal_position"] for servo in writing]
    if any((one.address, one.size) != (address, length) for one in registers):
        return None
    plain = [servo.plain_goal for servo in writing]
    senses = [one for one in plain if one is not None]
    if len(senses) < len(plain):
        return None
    least, most = zip(*(servo.table.goal_range() for servo in writing), strict=True)
    who = [listeners.every.index(servo) for servo in writing]
    in_order = who == list(range(len(listeners.every)))
    return GoalWrite(writing, layout, least, most, slice(None) if in_order else who, tuple(senses))
