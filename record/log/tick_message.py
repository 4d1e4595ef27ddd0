"""A tick as one message, complete: written and read back without loss.

Layout 1 is that of logs from before there was an estimator: no absolute poses among the inputs, no
estimate at the end. Layout 2 has the bytes of layout 3 under names that misled: its ``estimate_*`` was
dead reckoning, its ``odometry`` the estimate. Layout 3 is that of logs from before there was an IMU: no
readings of one among the inputs, no gyro bias in the estimate.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from model.values.contact import ContactSolution, Support, Traction
from model.values.estimate import Estimate
from model.values.faults import Fault, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.quick import quick
from model.values.readings import (
    BodyTruth,
    ForceRecord,
    ImuRecord,
    PoseRecord,
    ServoReadings,
)
from model.values.tick import DeadReckoning, Inputs, LoopTiming, Mode, Request, Tick
from record.log.cdr import HEADER, CdrReader, CdrWriter, text_bytes
from record.log.estimate_message import (
    BEFORE_SOURCES,
    ESTIMATE_TEXT,
    SCOPE,
    SOURCES,
    read_estimate,
    write_estimate,
)
from record.log.fields import Fields
from record.message_form import FormSource, MessagePart

TRANSDUCERS = 6
LAYOUT = 4  # of ticks written today
WITHOUT_ESTIMATE = 1  # the layout that has none
Encoder: TypeAlias = Callable[[Tick, tuple[bytes, ...]], bytes | None]
# A form is worked out when so many ticks have had it, which takes as long as encoding fifty of them.
WORTH_IT = 50
MOST_FORMS = 64
MOST_RECORDS = 4
VARYING = frozenset({"estimate.innovation", "estimate.source_nis", "estimate.source_dof"})
REQUEST = Fields(
    Request,
    "uint8 request_intent", "string request_gait", "float64 request_frequency_hz",
    "float64 request_steer", "uint8 request_reason",
)  # fmt: skip
TIMING = Fields(
    LoopTiming, "int64 deadline_ns", "int64 lateness_ns", "int64 missed", "int64 busy_ns"
)
SERVOS = Fields(
    ServoReadings,
    "int64 servos_t_ns", "int64[] position_ticks", "int64[] velocity_counts",
    "int64[] current_counts", "int64[] duty_counts", "int64[] voltage_counts",
    "int64[] servo_temperature_c", "int64[] error_byte", "int64[] hardware_error",
    "bool[] servo_valid", "int64[] servo_age_ns",
)  # fmt: skip
FORCE_RECORD = Fields(
    ForceRecord,
    "int64 t_ns", "int64 device_ticks", "int64 sequence", "int64[2] status", "int64 battery",
    "int64 mask", "int64[36] counts 6", "bool[6] present", "bool[6] saturated",
)  # fmt: skip
TRUTH = Fields(
    BodyTruth,
    "int64 truth_t_ns", "float64[3] truth_position_w", "float64[4] truth_quaternion_xyzw",
    "float64[3] truth_velocity_b", "float64[3] truth_angular_velocity_b",
    "float64[] truth_foot_position_w 3", "float64[] truth_foot_velocity_w 3",
    "float64[] truth_foot_force_b 3", "bool[] truth_contact",
)  # fmt: skip
FAULT = Fields(Fault, "uint8 kind", "string source", "string detail")
POSE = Fields(
    PoseRecord,
    "int64 t_ns", "float64[3] position_w", "float64[4] quaternion_xyzw", "float64 sd_position_m",
    "float64 sd_angle_rad",
)  # fmt: skip
IMU = Fields(
    ImuRecord,
    "int64 t_ns", "float64 yaw_rate_rad_s", "float64 roll_rad", "float64 pitch_rad",
)  # fmt: skip
JOINTS = Fields(
    JointState,
    "int64 joints_t_ns", "float64[] angle_rad", "float64[] rate_rad_s", "float64[] current_a",
    "float64[] duty", "float64[] voltage_v", "float64[] temperature_c", "bool[] joints_valid",
)  # fmt: skip
FORCES = Fields(FootForces, "int64 forces_t_ns", "float64[] force_n 3", "bool[] force_valid")
WISHED, SENT = (
    Fields(
        JointCommand,
        f"int64 {who}_t_ns", f"float64[] {who}_angle_rad", f"float64[] {who}_rate_rad_s",
        f"bool {who}_torque",
    )
    for who in ("wished", "sent")
)  # fmt: skip
FEET = Fields(FootMotion, "float64[] foot_position_b 3", "float64[] foot_velocity_b 3")
SUPPORT = Fields(
    Support,
    "bool support_converged", "string support_reason", "float64 height_m", "float64 slope_x",
    "float64 slope_y", "float64[] load_n", "bool[] contact", "int64 switches",
)  # fmt: skip
TRACTION = Fields(
    Traction,
    "bool traction_valid", "string traction_reason", "float64[3] velocity_b", "float64[] slip_b 2",
    "float64[] force_b 3",
)  # fmt: skip
DEAD_RECKONING = Fields(
    DeadReckoning,
    "int64 dead_reckoning_t_ns", "float64[2] dead_reckoning_position_m",
    "float64 dead_reckoning_yaw_rad", "float64[3] dead_reckoning_velocity_b",
    "bool dead_reckoning_valid",
)  # fmt: skip
# The outputs of a tick that have fields of their own, each with where it is in a tick.
_OUTPUTS: dict[str, Fields[Any]] = {
    "joints": JOINTS,
    "forces": FORCES,
    "wished": WISHED,
    "sent": SENT,
    "feet": FEET,
    "contact.support": SUPPORT,
    "contact.traction": TRACTION,
    "dead_reckoning": DEAD_RECKONING,
}
# By the field of the message, where it is in a tick: faults and estimate are beside it.
OUTPUT_PLACES = {
    name: f"{where}.{attribute}"
    for where, part in _OUTPUTS.items()
    for attribute, name in part.pairs
} | {"gait_phase": "gait_phase"}
# By the name of their type in ROS 2. A tick's inputs come first, then its outputs.
TICK_DEFINITIONS = {
    "bigant_msgs/Fault": FAULT.text,
    "bigant_msgs/ForceRecord": FORCE_RECORD.text,
    "bigant_msgs/PoseRecord": POSE.text,
    "bigant_msgs/ImuRecord": IMU.text,
    "bigant_msgs/Estimate": ESTIMATE_TEXT,
    "bigant_msgs/Tick": (
        f"int64 t_ns\nint64 index\nuint8 mode\nuint8 stop_reason\n{REQUEST.text}{TIMING.text}"
        f"bool servos_attached\n{SERVOS.text}bigant_msgs/ForceRecord[] force_records\n"
        f"bool truth_known\n{TRUTH.text}bigant_msgs/Fault[] input_faults\n"
        f"bigant_msgs/PoseRecord[] pose_records\nbigant_msgs/ImuRecord[] imu_records\n"
        f"{JOINTS.text}{FORCES.text}float64 gait_phase\n"
        f"{WISHED.text}{SENT.text}{FEET.text}{SUPPORT.text}{TRACTION.text}"
        f"{DEAD_RECKONING.text}bigant_msgs/Fault[] faults\nbigant_msgs/Estimate[] estimate\n"
    ),
}


def encode_tick(tick: Tick) -> bytes:
    """Return a tick as a message."""
    w = CdrWriter()
    w.record("qqBB", tick.t_ns, tick.index, tick.mode.value, tick.stop_reason.value)
    inputs = tick.inputs
    REQUEST.write(w, inputs.request)
    TIMING.write(w, inputs.timing)
    w.record("?", inputs.servos is not None)
    SERVOS.write(w, inputs.servos or no_servos(len(tick.wished.angle_rad)))
    FORCE_RECORD.write_all(w, inputs.forces)
    w.record("?", inputs.truth is not None)
    TRUTH.write(w, inputs.truth or no_truth(len(tick.feet.position_m)))
    FAULT.write_all(w, inputs.faults)
    POSE.write_all(w, inputs.poses)
    IMU.write_all(w, inputs.imu)
    _write_outputs(w, tick)
    return w.done()


@cache
def no_servos(joints: int) -> ServoReadings:
    """What is written of the readings of so many joints where there are none."""
    zeros = np.zeros(joints, dtype=np.int64)
    flags = np.zeros(joints, dtype=bool)
    return ServoReadings(0, zeros, zeros, zeros, zeros, zeros, zeros, zeros, zeros, flags, zeros)


@cache
def no_truth(legs: int) -> BodyTruth:
    """What is written of the ground truth of so many legs where there is none."""
    three, feet = np.full(3, np.nan), np.full((legs, 3), np.nan)
    flags = np.zeros(legs, dtype=bool)
    return BodyTruth(0, three, np.full(4, np.nan), three, three, feet, feet, feet, flags)


def _write_outputs(w: CdrWriter, tick: Tick, layout: int = LAYOUT) -> None:
    JOINTS.write(w, tick.joints)
    FORCES.write(w, tick.forces)
    w.record("d", tick.gait_phase)
    WISHED.write(w, tick.wished)
    SENT.write(w, tick.sent)
    FEET.write(w, tick.feet)
    SUPPORT.write(w, tick.contact.support)
    TRACTION.write(w, tick.contact.traction)
    DEAD_RECKONING.write(w, tick.dead_reckoning)
    FAULT.write_all(w, tick.faults)
    if layout > 1:
        write_estimate(w, tick.estimate, with_sources=layout > 3)


class TickEncoder:
    """Encodes the ticks of one log: those that are like many before them in one go, to the same bytes.

    A tick with a fault, a pose or a reading of an IMU is encoded as any.
    """

    def __init__(self) -> None:
        self._forms: dict[tuple[int, ...], Encoder] = {}
        self._seen: Counter[tuple[int, ...]] = Counter()

    def encode(self, tick: Tick) -> bytes:
        """Return a tick as a message."""
        form = _form_of(tick)
        if form is None:
            return encode_tick(tick)
        key, texts = form
        encoder = self._forms.get(key)
        if encoder is not None:
            return encoder(tick, texts) or encode_tick(tick)
        if len(self._forms) < MOST_FORMS:
            self._seen[key] += 1
            if self._seen[key] >= WORTH_IT:
                self._forms[key] = encoder_like(tick)
        return encode_tick(tick)


def _form_of(tick: Tick) -> tuple[tuple[int, ...], tuple[bytes, ...]] | None:
    """Return what tells a tick's form from others, and its texts; None if it has none."""
    inputs, contact, estimate = tick.inputs, tick.contact, tick.estimate
    lists = inputs.faults or inputs.poses or inputs.imu or tick.faults
    if lists or len(inputs.forces) > MOST_RECORDS:
        return None
    texts = [inputs.request.gait, contact.support.reason, contact.traction.reason]
    key = [len(inputs.forces), len(tick.wished.angle_rad), len(tick.feet.position_m)]
    if estimate is not None:  # the key is longer with one
        texts += (estimate.reason, estimate.remark)
        key += (
            len(estimate.innovation) > 0, len(estimate.source_nis) > 0, len(estimate.source_dof) > 0,
        )  # fmt: skip
    encoded = tuple(map(text_bytes, texts))
    return (*key, *[len(text) & 7 for text in encoded]), encoded


def encoder_like(tick: Tick) -> Encoder:
    """Return an encoder for ticks of the form of an example."""
    names = {
        "inputs": "tick.inputs",
        "request": "inputs.request",
        "timing": "inputs.timing",
        "servos": "inputs.servos or no_servos(len(tick.wished.angle_rad))",
        "truth": "inputs.truth or no_truth(len(tick.feet.position_m))",
        **{f"record_{at}": f"inputs.forces[{at}]" for at in range(len(tick.inputs.forces))},
        "joints": "tick.joints",
        "forces": "tick.forces",
        "wished": "tick.wished",
        "sent": "tick.sent",
        "feet": "tick.feet",
        "support": "tick.contact.support",
        "traction": "tick.contact.traction",
        "reckoned": "tick.dead_reckoning",
        "estimate": "tick.estimate",
    }
    scope = {**SCOPE, "no_servos": no_servos, "no_truth": no_truth, "tick": tick}
    before = [f"{name} = {expression}" for name, expression in names.items()]
    exec("\n".join(before), scope)
    source = FormSource(HEADER, scope, VARYING)

    def add(name: str, parts: Sequence[MessagePart]) -> None:
        source.add([part.of(name) for part in parts])

    source.numbers("qqBB", "tick.t_ns, tick.index, tick.mode.value, tick.stop_reason.value")
    add("request", REQUEST.parts)
    add("timing", TIMING.parts)
    source.numbers("?", "inputs.servos is not None")
    add("servos", SERVOS.parts)
    source.numbers("I", str(len(tick.inputs.forces)))
    for at in range(len(tick.inputs.forces)):
        add(f"record_{at}", FORCE_RECORD.parts)
    source.numbers("?", "inputs.truth is not None")
    add("truth", TRUTH.parts)
    for _ in range(3):  # faults, poses, readings of an IMU
        source.numbers("I", "0")
    add("joints", JOINTS.parts)
    add("forces", FORCES.parts)
    source.numbers("d", "tick.gait_phase")
    add("wished", WISHED.parts)
    add("sent", SENT.parts)
    add("feet", FEET.parts)
    add("support", SUPPORT.parts)
    add("traction", TRACTION.parts)
    add("reckoned", DEAD_RECKONING.parts)
    source.numbers("I", "0")  # faults
    source.numbers("I", "0" if tick.estimate is None else "1")
    if tick.estimate is not None:
        add("estimate", (*BEFORE_SOURCES, *SOURCES))
    return source.made("tick, texts", before)


def says_the_same(
    tick: Tick, message: bytes, inputs_end: int, layout: int = LAYOUT, *, estimate: bool = True
) -> bool:
    """Tell whether a message holds exactly the outputs of a tick, without taking it apart.

    Args:
        tick: The tick, made from the inputs in the message.
        message: The message.
        inputs_end: Where its inputs end, as ``decode_inputs`` returned it.
        layout: Layout of the message; of layout 1 all is compared that it has.
        estimate: Whether its estimate is compared, too.
    """
    w = CdrWriter(at=inputs_end)
    _write_outputs(w, tick, layout if estimate else WITHOUT_ESTIMATE)
    begin = len(HEADER)
    decided = message[begin + 16], message[begin + 17]  # behind time and number
    same_decisions = decided == (tick.mode.value, tick.stop_reason.value)
    outputs = w.done()
    there = message[begin + inputs_end :]
    return same_decisions and outputs == (there if estimate else there[: len(outputs)])


def estimates_the_same(estimate: Estimate, message: bytes, begin: int) -> bool:
    """Tell whether a message of today's layout ends with exactly an estimate.

    Args:
        estimate: The estimate.
        message: The message.
        begin: Where its estimate begins, counted from behind the header.
    """
    w = CdrWriter(at=begin)
    write_estimate(w, estimate)
    return w.done() == message[len(HEADER) + begin :]


@quick
@dataclass(frozen=True, slots=True, eq=False)
class TickInputs:
    """The part of a tick message that a replay begins from.

    Attributes:
        t_ns: Time of the tick.
        index: Its number.
        inputs: Its inputs, without the truth: no step may know it.
        end: Where they end in the message; see ``says_the_same``.
    """

    t_ns: int
    index: int
    inputs: Inputs
    end: int


def decode_inputs(data: bytes, layout: int = LAYOUT) -> TickInputs:
    """Return time, number and inputs of the tick in a message, and leave the rest as it is.

    Args:
        data: The message.
        layout: Its layout.

    Raises:
        ValueError: The message is damaged.
    """
    r = CdrReader(data)
    t_ns, index, _, _ = r.record("qqBB")
    inputs = _read_inputs(r, layout, with_truth=False)
    return TickInputs(t_ns, index, inputs, r.at)


def decode_tick(data: bytes, layout: int = LAYOUT, seen: TickInputs | None = None) -> Tick:
    """Return the tick in a message.

    Args:
        data: The message.
        layout: Its layout.
        seen: Its inputs, if ``decode_inputs`` has returned them already; the truth is then absent.

    Raises:
        ValueError: The message is damaged.
    """
    r = CdrReader(data)
    t_ns, index, mode, stop_reason = r.record("qqBB")
    if seen is None:
        inputs = _read_inputs(r, layout)
    else:
        inputs, r.at = seen.inputs, seen.end
    return Tick(
        t_ns=t_ns,
        index=index,
        mode=Mode(mode),
        stop_reason=StopReason(stop_reason),
        inputs=inputs,
        joints=JOINTS.read(r),
        forces=FORCES.read(r),
        gait_phase=r.record("d")[0],
        wished=WISHED.read(r),
        sent=SENT.read(r),
        feet=FEET.read(r),
        contact=ContactSolution(SUPPORT.read(r), TRACTION.read(r)),
        dead_reckoning=DEAD_RECKONING.read(r),
        faults=FAULT.read_all(r),
        estimate=read_estimate(r, with_sources=layout > 3) if layout > 1 else None,
    )


def _read_inputs(r: CdrReader, layout: int, *, with_truth: bool = True) -> Inputs:
    request, timing, (attached,) = REQUEST.read(r), TIMING.read(r), r.record("?")
    servos, forces, (truth_known,) = SERVOS.read(r), FORCE_RECORD.read_all(r), r.record("?")
    truth = None
    if with_truth:
        truth = TRUTH.read(r)
    else:
        TRUTH.skip(r)
    return Inputs(
        servos=servos if attached else None,
        forces=forces,
        request=request,
        timing=timing,
        truth=truth if truth_known else None,
        faults=FAULT.read_all(r),
        poses=POSE.read_all(r) if layout > 1 else (),
        imu=IMU.read_all(r) if layout > 3 else (),
    )
