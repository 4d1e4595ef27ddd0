"""A tick as one message, complete: written and read back without loss.

The order of fields is that of ``bigant_msgs/msg/Tick`` in ``record.log.definitions``. Layout 1 is that of
logs from before there was an estimator: no absolute poses among the inputs, no estimate at the end.
Layout 2 has the bytes of layout 3 under names that misled: its ``estimate_*`` was dead reckoning, its
``odometry`` the estimate.
"""

from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.contact import ContactSolution, Support, Traction
from model.values.faults import Fault, FaultKind, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.readings import BodyTruth, ForceRecord, ServoReadings
from model.values.tick import DeadReckoning, Inputs, Intent, LoopTiming, Mode, Request, Tick
from record.log.cdr import HEADER, CdrReader, CdrWriter
from record.log.estimate_message import (
    read_estimate,
    read_poses,
    write_estimate,
    write_poses,
)

TRANSDUCERS = 6
LAYOUT = 3  # of ticks written today


def encode_tick(tick: Tick) -> bytes:
    """Return a tick as a message."""
    w = CdrWriter()
    w.record("qqBB", tick.t_ns, tick.index, tick.mode.value, tick.stop_reason.value)
    _write_inputs(w, tick.inputs, len(tick.wished.angle_rad))
    write_poses(w, tick.inputs.poses)
    _write_outputs(w, tick)
    return w.done()


def says_the_same(tick: Tick, message: bytes, inputs_end: int, layout: int = LAYOUT) -> bool:
    """Tell whether a message holds exactly the outputs of a tick, without taking it apart.

    Args:
        tick: The tick, made from the inputs in the message.
        message: The message.
        inputs_end: Where its inputs end, as ``decode_inputs`` returned it.
        layout: Layout of the message; of layout 1 all is compared that it has.
    """
    w = CdrWriter(at=inputs_end)
    _write_outputs(w, tick, layout)
    begin = len(HEADER)
    decided = message[begin + 16], message[begin + 17]  # behind time and number
    same_decisions = decided == (tick.mode.value, tick.stop_reason.value)
    return same_decisions and w.done() == message[begin + inputs_end :]


def _write_outputs(w: CdrWriter, tick: Tick, layout: int = LAYOUT) -> None:
    joints = tick.joints
    w.i64(joints.t_ns)
    w.f64s(
        joints.angle_rad, joints.rate_rad_s, joints.current_a, joints.duty, joints.voltage_v,
        joints.temperature_c,
    )  # fmt: skip
    w.flags(joints.valid)
    w.i64(tick.forces.t_ns)
    w.f64s(tick.forces.force_n)
    w.flags(tick.forces.valid)
    w.f64(tick.gait_phase)
    for command in (tick.wished, tick.sent):
        w.i64(command.t_ns)
        w.f64s(command.angle_rad, command.rate_rad_s)
        w.flag(command.torque)
    w.f64s(tick.feet.position_m, tick.feet.velocity_m_s)
    _write_contact(w, tick.contact)
    reckoned = tick.dead_reckoning
    w.record(
        "qdddddd?", reckoned.t_ns, *reckoned.position_m.tolist(), reckoned.yaw_rad,
        *reckoned.velocity_B.tolist(), reckoned.valid,
    )  # fmt: skip
    _write_faults(w, tick.faults)
    if layout > 1:
        write_estimate(w, tick.estimate)


def _write_inputs(w: CdrWriter, inputs: Inputs, count: int) -> None:
    request, timing = inputs.request, inputs.timing
    w.u8(request.intent.value)
    w.text(request.gait)
    w.record(
        "ddBqqqq", request.frequency_hz, request.steer, request.reason.value, timing.deadline_ns,
        timing.lateness_ns, timing.missed, timing.busy_ns,
    )  # fmt: skip
    _write_servos(w, inputs.servos, count)
    w.u32(len(inputs.forces))
    for record in inputs.forces:
        _write_force_record(w, record)
    _write_truth(w, inputs.truth, count)
    _write_faults(w, inputs.faults)


def _write_servos(w: CdrWriter, servos: ServoReadings | None, count: int) -> None:
    w.flag(servos is not None)
    if servos is None:
        w.i64(0)
        for _ in range(8):
            w.i64s(np.zeros(count, dtype=np.int64))
        w.flags(np.zeros(count, dtype=bool))
        w.i64s(np.zeros(count, dtype=np.int64))
        return
    w.i64(servos.t_ns)
    w.i64s(
        servos.position_ticks, servos.velocity_counts, servos.current_counts, servos.duty_counts,
        servos.voltage_counts, servos.temperature_c, servos.error_byte, servos.hardware_error,
    )  # fmt: skip
    w.flags(servos.valid)
    w.i64s(servos.age_ns)


def _write_force_record(w: CdrWriter, record: ForceRecord) -> None:
    w.i64(record.t_ns, record.device_ticks, record.sequence)
    w.i64_array(record.status)
    w.i64(record.battery, record.mask)
    w.i64_array(record.counts)
    w.flag_array(record.present)
    w.flag_array(record.saturated)


def _write_truth(w: CdrWriter, truth: BodyTruth | None, count: int) -> None:
    w.flag(truth is not None)
    if truth is None:
        w.i64(0)
        w.f64_array(np.full(13, np.nan))
        for _ in range(3):
            w.f64s(np.full(3 * count, np.nan))
        w.flags(np.zeros(count, dtype=bool))
        return
    w.i64(truth.t_ns)
    for values in (
        truth.position_W,
        truth.quaternion_xyzw,
        truth.velocity_B,
        truth.angular_velocity_B,
    ):
        w.f64_array(values)
    w.f64s(truth.foot_position_W, truth.foot_velocity_W, truth.foot_force_B)
    w.flags(truth.contact)


def _write_contact(w: CdrWriter, contact: ContactSolution) -> None:
    support, traction = contact.support, contact.traction
    w.flag(support.converged)
    w.text(support.reason)
    w.f64(support.height_m, support.slope_x, support.slope_y)
    w.f64s(support.load_n)
    w.flags(support.contact)
    w.i64(support.switches)
    w.flag(traction.valid)
    w.text(traction.reason)
    w.f64_array(traction.velocity_B)
    w.f64s(traction.slip_B, traction.force_B)


def _write_faults(w: CdrWriter, faults: tuple[Fault, ...]) -> None:
    w.u32(len(faults))
    for fault in faults:
        w.u8(fault.kind.value)
        w.text(fault.source)
        w.text(fault.detail)


@dataclass(frozen=True, slots=True, eq=False)
class TickInputs:
    """The part of a tick message that a replay begins from.

    Attributes:
        t_ns: Time of the tick.
        index: Its number.
        inputs: Its inputs.
        end: Where they end in the message; see ``says_the_same``.
    """

    t_ns: int
    index: int
    inputs: Inputs
    end: int


def decode_inputs(data: bytes, layout: int = LAYOUT) -> TickInputs:
    """Return time, number and inputs of the tick in a message, and leave the rest as it is.

    The truth is left out: no step may know it.

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
        inputs = seen.inputs
        r.go_on_at(seen.end)
    joints_ns = r.i64()
    angle, rate, current, duty, voltage, temperature = r.f64_rows(6)
    joints = JointState(joints_ns, angle, rate, current, duty, voltage, temperature, r.flags())
    forces = FootForces(r.i64(), _rows(r.f64s(), 3), r.flags())
    gait_phase = r.f64()
    wished, sent = _read_command(r), _read_command(r)
    feet = FootMotion(*(_rows(values, 3) for values in r.f64_rows(2)))
    contact = _read_contact(r)
    reckoned = DeadReckoning(r.i64(), r.f64_array(2), r.f64(), r.f64_array(3), r.flag())
    return Tick(
        t_ns=t_ns,
        index=index,
        mode=Mode(mode),
        stop_reason=StopReason(stop_reason),
        inputs=inputs,
        joints=joints,
        forces=forces,
        gait_phase=gait_phase,
        wished=wished,
        sent=sent,
        feet=feet,
        contact=contact,
        dead_reckoning=reckoned,
        faults=_read_faults(r),
        estimate=read_estimate(r) if layout > 1 else None,
    )


def _read_command(r: CdrReader) -> JointCommand:
    t_ns = r.i64()
    angle, rate = r.f64_rows(2)
    return JointCommand(t_ns, angle, rate, r.flag())


def _rows(values: FloatArray, width: int) -> FloatArray:
    return values.reshape(-1, width)


def _read_inputs(r: CdrReader, layout: int, *, with_truth: bool = True) -> Inputs:
    intent, gait = Intent(r.u8()), r.text()
    frequency_hz, steer, reason, *timing, attached, t_ns = r.record("ddBqqqq?q")
    request = Request(intent, gait, frequency_hz, steer, StopReason(reason))
    position, velocity, current, duty, voltage, temperature, error, hardware = r.i64_rows(8)
    servos = ServoReadings(
        t_ns, position, velocity, current, duty, voltage, temperature, error, hardware, r.flags(),
        r.i64s(),
    )  # fmt: skip
    forces = tuple(_read_force_record(r) for _ in range(r.u32()))
    truth = _read_truth(r, wanted=with_truth)
    return Inputs(
        servos=servos if attached else None,
        forces=forces,
        request=request,
        timing=LoopTiming(*timing),
        truth=truth,
        faults=_read_faults(r),
        poses=read_poses(r) if layout > 1 else (),
    )


def _read_force_record(r: CdrReader) -> ForceRecord:
    t_ns, device_ticks, sequence = r.record("qqq")
    numbers = r.i64_array(2 + 2 + TRANSDUCERS * 6)
    battery, mask = numbers[2:4].tolist()
    flags = r.flag_array(2 * TRANSDUCERS)
    return ForceRecord(
        t_ns=t_ns,
        device_ticks=device_ticks,
        sequence=sequence,
        status=numbers[:2],
        battery=battery,
        mask=mask,
        counts=numbers[4:].reshape(TRANSDUCERS, 6),
        present=flags[:TRANSDUCERS],
        saturated=flags[TRANSDUCERS:],
    )


def _read_truth(r: CdrReader, *, wanted: bool) -> BodyTruth | None:
    known = r.flag()
    if not wanted:
        r.pass_numbers(1 + 3 + 4 + 3 + 3)
        for _ in range(3):
            r.pass_sequence()
        r.pass_flags(r.u32())
        return None
    truth = BodyTruth(
        t_ns=r.i64(),
        position_W=r.f64_array(3),
        quaternion_xyzw=r.f64_array(4),
        velocity_B=r.f64_array(3),
        angular_velocity_B=r.f64_array(3),
        foot_position_W=_rows(r.f64s(), 3),
        foot_velocity_W=_rows(r.f64s(), 3),
        foot_force_B=_rows(r.f64s(), 3),
        contact=r.flags(),
    )
    return truth if known else None


def _read_contact(r: CdrReader) -> ContactSolution:
    support = Support(
        converged=r.flag(),
        reason=r.text(),
        height_m=r.f64(),
        slope_x=r.f64(),
        slope_y=r.f64(),
        load_n=r.f64s(),
        contact=r.flags(),
        switches=r.i64(),
    )
    traction = Traction(
        valid=r.flag(),
        reason=r.text(),
        velocity_B=r.f64_array(3),
        slip_B=_rows(r.f64s(), 2),
        force_B=_rows(r.f64s(), 3),
    )
    return ContactSolution(support, traction)


def _read_faults(r: CdrReader) -> tuple[Fault, ...]:
    return tuple(Fault(FaultKind(r.u8()), r.text(), r.text()) for _ in range(r.u32()))
