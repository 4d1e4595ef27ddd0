"""Steps 1 and 2: who talks unasked, who answers to which id, how fast."""

from collections.abc import Sequence
from contextlib import closing

import numpy as np
from dynamixel_sdk import COMM_SUCCESS

from drivers.ati.links import DatagramLink
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import COMMON, READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.frames import (
    BROADCAST_ID,
    LARGEST_ID,
    STATUS_BYTES,
    Instruction,
    StatusError,
    build_instruction,
)
from drivers.dynamixel.model_words import mismatch_words, model_name
from drivers.dynamixel.port import BITS_PER_BYTE, ClockedPort
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.scan import ScannedServo, broadcast_ping, id_is_shared
from drivers.dynamixel.setup import speaks_protocol_1
from drivers.dynamixel.units import RETURN_DELAY_UNIT_S as DELAY_UNIT_S
from model.values.wire import Wire
from robot.bringup.first_day.day import Day, received
from robot.bringup.preflight.finding import failed, passed, skipped, warned
from robot.console.table import number_text
from robot.run.force_unit import why_no_unit

LISTEN_S = 3.0
LOOK_NS = 20_000_000
TIMED_READS = 30
# A reply of this many bytes fills an FTDI packet: no latency timer holds it back.
FULL_PACKET_BYTES = 62
FIRST_OF_FULL = COMMON["indirect_address_1"].address
# Each pause between two pings is longer by this: every phase of a latency timer's grid comes up.
PING_STEP_NS = 400_000
PINGS = 40
NO_TIMER_S = 0.3e-3


def listen(day: Day) -> None:
    """Step 1: open both devices' ports, send nothing, and see who talks."""
    wires = day.wires()
    port, clock = wires.port, wires.clock
    links: list[DatagramLink] = []
    port.openPort()
    try:
        link = day.site.datagrams(day.tap)
        links += [link] if link is not None else []
        end_ns = clock.now_ns() + round(LISTEN_S * 1e9)
        while clock.now_ns() < end_ns:
            clock.sleep_until_ns(clock.now_ns() + LOOK_NS)
            if port.getBytesAvailable():
                port.readPort(1024)
            for one in links:
                one.receive()
    finally:
        port.closePort()
        for one in links:
            one.close()
    pieces = day.heard()
    bus, unit = received(pieces, Wire.SERVO_BUS), received(pieces, Wire.FORCE_DATAGRAMS)
    what = f"in {LISTEN_S:g} s without a request"
    if bus:
        advice = "who else drives this bus? unplug other adapters and controllers"
        day.note(failed("servo bus", f"{len(bus)} bytes {what}: {bus[:16].hex(' ')}", advice))
    else:
        day.note(passed("servo bus", f"silent {what}"))
    if not links:
        day.note(skipped("force unit", why_no_unit(day.config.force_sensor)))
    elif unit:
        advice = "an earlier program never stopped it; the next one does (or switch it off and on)"
        day.note(warned("force unit", f"{len(unit)} bytes {what}", advice))
    else:
        day.note(passed("force unit", f"silent {what}"))


def ids(day: Day) -> None:
    """Step 2: ping all, each id of the robot file, and an id that nobody has; time the answers."""
    bus = day.bus()
    bus.open()
    with closing(bus):
        port = bus.servos()[0].port
        answered = broadcast_ping(port)
        if not _who(day, bus, answered):
            return
        absent = next(
            i for i in range(LARGEST_ID, 0, -1) if i not in {s.servo_id for s in answered}
        )
        requests = ServoRequests(port)
        _absent(day, requests, absent)
        _chain(day, requests, absent)
        _bad_crc(day, port, int(bus.settings.ids[0]))
        _timing(day, requests)


def _who(day: Day, bus: ServoBus, answered: Sequence[ScannedServo]) -> bool:
    """Say who answers; return whether the rest makes sense."""
    legs = {int(i): leg for i, leg in zip(bus.settings.ids, bus.settings.names, strict=True)}
    there = {servo.servo_id: servo for servo in answered}
    strangers = [number for number in there if number not in legs]
    missing = [number for number in legs if number not in there]
    # a broadcast may be spoilt by a collision: each is asked by itself as well
    silent = [s for s in bus.servos() if s.servo_id in missing and not s.answers()]
    missing = [servo.servo_id for servo in silent]
    models = bus.settings.model_of_id
    for number, servo in there.items():
        words = mismatch_words(models[number], servo.model) if number in models else ""
        if words:
            kind = f"{model_name(servo.model)}, firmware {servo.firmware}"
            day.note(failed(f"id {number}", kind, f"it {words}"))
    if missing:
        words = ", ".join(f"{number} ({legs[number]})" for number in missing)
        advice = "check its plug and power, then baud rate and id with bigant devices"
        if strangers:
            others = ", ".join(map(str, strangers))
            words += f"; id {others} answers and is not in the robot file"
            advice = (
                "change dynamixel_id in [legs] of the robot file, or the servo: bigant servo setup "
                f"--id {strangers[0]} --new-id {missing[0]}"
            )
        old = [servo.servo_id for servo in silent if speaks_protocol_1(servo)]
        if old:
            words += f"; id {', '.join(map(str, old))} answers in protocol 1.0"
            advice = f"put the {models[old[0]].name} firmware on it with Dynamixel Wizard"
        day.note(failed("ids", f"no answer from {words}", advice))
        return False
    requests = ServoRequests(bus.servos()[0].port)
    shared = [number for number in legs if id_is_shared(requests, number)]
    if shared:
        advice = "connect one at a time: bigant servo setup --id N --new-id M"
        day.note(failed("ids", f"two servos share id {', '.join(map(str, shared))}", advice))
        return False
    day.note(passed("ids", f"{', '.join(map(str, legs))} answer, each once"))
    if strangers:
        advice = "nothing of ours speaks to it; take it off the bus, or put it into the robot file"
        day.note(warned("strangers", f"id {', '.join(map(str, strangers))} answers too", advice))
    versions = sorted({servo.firmware for servo in there.values()})
    if len(versions) == 1:
        how = f"pings of ids {', '.join(map(str, legs))}"
        day.settled("servo", "firmware", versions[0], how)
        day.note(passed("firmware", f"version {versions[0]} on all"))
    else:
        found = f"versions {', '.join(map(str, versions))}"
        day.note(warned("firmware", found, "give all servos the same (Dynamixel Wizard)"))
    return True


def _absent(day: Day, requests: ServoRequests, absent: int) -> None:
    answer = requests.ask(absent, Instruction.PING)
    if answer.data is None and not answer.error:
        day.note(passed("an absent id", f"id {absent}: no answer, as it should be"))
    else:
        day.note(failed("an absent id", f"id {absent} answers", "who is it? bigant devices"))


def _chain(day: Day, requests: ServoRequests, absent: int) -> None:
    """Ask all and, in their middle, an id that nobody has: do those behind it still answer?"""
    known = [int(i) for i in day.config.servo_bus.ids]
    middle = len(known) // 2
    asked = [*known[:middle], absent, *known[middle:]]
    answers = requests.sync_read(asked, READ_ADDRESS, READ_LENGTH, 1.0)
    heard = {i for i, a in zip(asked, answers, strict=True) if a.data is not None}
    behind = [i for i in known[middle:] if i not in heard]
    words = f"a sync read of {', '.join(map(str, asked))}"
    if not behind and len(heard) == len(known):
        day.note(passed("a broken chain", f"{words}: all but {absent} answer"))
    elif behind and all(i in heard for i in known[:middle]):
        found = f"{words}: those behind {absent} stay silent ({', '.join(map(str, behind))})"
        advice = "one dead servo will silence those behind it: the robot stops then, as it should"
        day.note(warned("a broken chain", found, advice))
    else:
        silent = [str(i) for i in known if i not in heard]
        advice = "repeat this step; if it stays so check cables with bigant servo watch"
        day.note(warned("a broken chain", f"{words}: no answer from {', '.join(silent)}", advice))


def _bad_crc(day: Day, port: ClockedPort, servo_id: int) -> None:
    """Send one ping with a wrong CRC."""
    frame = bytearray(build_instruction(servo_id, Instruction.PING))
    frame[-1] ^= 0xFF
    requests = ServoRequests(port)
    requests.send(bytes(frame))
    port.setPacketTimeout(len(frame) + STATUS_BYTES)
    status, _ = requests.next_status()
    answers = status is not None and status.error is not None
    error = status.error or 0 if status is not None else 0
    if answers and error & 0x7F != StatusError.CRC:
        found = f"answered with error {error}"
        day.note(warned("a damaged ping", found, "only a CRC error was expected; keep the log"))
        return
    day.settled("servo", "answers_bad_crc", answers, f"one ping of id {servo_id} with a wrong CRC")
    day.note(passed("a damaged ping", "answered with a CRC error" if answers else "no answer"))


def _timing(day: Day, requests: ServoRequests) -> None:
    """Time one servo's own work by replies that no adapter keeps back, and the adapter by short ones."""
    port, known = requests.port, [int(i) for i in day.config.servo_bus.ids]
    length = FULL_PACKET_BYTES - STATUS_BYTES
    delay = COMMON["return_delay_time"]
    answers = [requests.read(i, delay.address, delay.size).data for i in known]
    delays = [delay.decode(data) * DELAY_UNIT_S for data in answers if data is not None]
    byte_s = BITS_PER_BYTE / port.baudrate
    spent: dict[int, float] = {}
    for count in range(1, len(known) + 1):
        times = []
        for _ in range(TIMED_READS):
            began_ns = port.clock.now_ns()
            got = requests.sync_read(
                known[:count], FIRST_OF_FULL, length, 1e3 * max(delays, default=0.0005)
            )
            if all(answer.data is not None for answer in got):
                times.append((port.clock.now_ns() - began_ns) * 1e-9)
        if times:
            request = STATUS_BYTES + 3 + count
            bytes_s = (request + count * FULL_PACKET_BYTES) * byte_s
            spent[count] = float(np.median(times)) - bytes_s - sum(delays[:count])
    if len(spent) < 2:
        day.note(skipped("servo's own work", "long sync reads get no sound answers"))
        return
    slope, _ = np.polyfit(list(spent), list(spent.values()), 1)
    processing_s = max(0.0, float(slope))
    how = f"{TIMED_READS} sync reads each of 1 to {len(known)} servos, time less bytes, by servo"
    if len(known) > 1:
        day.settled("servo", "processing_s", round(processing_s, 6), how)
    day.note(passed("servo's own work", f"{processing_s * 1e6:.0f} us before an answer"))
    _adapter(day, requests, known[0], processing_s + delays[0])


def _adapter(day: Day, requests: ServoRequests, servo_id: int, servo_s: float) -> None:
    port, extra = requests.port, []
    for k in range(PINGS):
        port.clock.sleep_until_ns(port.clock.now_ns() + k * PING_STEP_NS)
        began_ns = port.clock.now_ns()
        if requests.ask(servo_id, Instruction.PING).code == COMM_SUCCESS:
            frame = len(build_instruction(BROADCAST_ID, Instruction.PING)) + STATUS_BYTES + 3
            spent_s = (port.clock.now_ns() - began_ns) * 1e-9
            extra.append(spent_s - frame * BITS_PER_BYTE / port.baudrate - servo_s)
    if not extra:
        return
    most, half = max(extra), float(np.median(extra))
    reported = port.latency_timer_ms
    found = f"keeps a short answer back for {half * 1e3:.2f} ms, {most * 1e3:.2f} ms at most"
    how = (
        f"{len(extra)} pings: {half * 1e3:.2f} ms longer than their bytes, {most * 1e3:.2f} at most"
    )
    if reported is not None:
        day.settled("adapter", "latency_timer_s", reported * 1e-3, f"the system says so; {how}")
        found += f"; its latency timer is {number_text(reported, 0)} ms"
    elif most < NO_TIMER_S:
        day.settled("adapter", "latency_timer_s", 0.0, how)
    if reported is not None and reported > 4:
        advice = "write 1 to latency_timer in /sys/bus/usb-serial/devices/...: docs/tutorial.md"
        day.note(warned("adapter", found, advice))
    else:
        day.note(passed("adapter", found))
