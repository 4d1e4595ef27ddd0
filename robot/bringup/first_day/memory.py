"""Step 3: every register of each servo, against robot file and factory, and what is between them."""

import time
from collections.abc import Iterator
from contextlib import closing

from drivers.dynamixel.catalog import MODEL_BY_NUMBER
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.image import ServoImage, read_image
from drivers.dynamixel.model_words import model_name
from drivers.dynamixel.registers import RegisterTable
from record.whole_file import write_text
from robot.bringup.first_day.day import Day
from robot.bringup.preflight.finding import Finding, failed, passed, warned
from robot.bringup.servo.backup import Backup, backup_text
from robot.bringup.servo.changes import in_words
from robot.bringup.servo.setup import differences, wanted_of
from robot.report.run_date import utc_words

# What turns legs the wrong way or lets a servo obey another's commands.
DANGEROUS = {"drive_mode", "secondary_id", "homing_offset"}
OURS = {"id", "baud_rate", "operating_mode"}
LONGEST_READ = 64
REGISTERS_FILE = "servos.toml"


def gaps(table: RegisterTable) -> list[tuple[int, int]]:
    """Return address and length of each gap of a control table, the longest cut short."""
    found, end = [], 0
    for register in sorted(table, key=lambda r: r.address):
        if register.address > end:
            found.append((end, min(LONGEST_READ, register.address - end)))
        end = max(end, register.end)
    return found


def registers(day: Day) -> None:
    """Step 3: read everything that each servo keeps, compare it, and read the gaps."""
    bus, images = day.bus(), []
    bus.open()
    with closing(bus):
        for servo in bus.servos():
            image = read_image(servo)
            images.append(image)
            _compare(day, servo, image)
        day.note(*_gap_findings(day, bus.servos()))
    stamp = utc_words(time.time_ns())
    text = backup_text(Backup(stamp, day.site.name, tuple(images)))
    write_text(day.folder / REGISTERS_FILE, text, "--folder")
    day.note(passed("kept", f"{REGISTERS_FILE}: {len(images)} servos (bigant servo restore)"))


def _compare(day: Day, servo: CheckedServo, image: ServoImage) -> None:
    model = MODEL_BY_NUMBER.get(image.model)
    if model is None or model.table is not servo.table:
        words = f"id {servo.servo_id} is {model_name(image.model)}, not what the robot file says"
        day.note(failed(servo.leg, words, "see what step 2 says of it"))
        return
    wanted = wanted_of(day.config, day.config.servo_bus.baud_rate, model)
    changes = differences(image, wanted, servo.servo_id)
    other = [
        f"{name} {in_words(name, value, model)}"
        for name, value in image.values.items()
        if name not in OURS and value != servo.table[name].initial
    ]
    factory = f"not as from the factory: {', '.join(other)}" if other else "as from the factory"
    if {change.name for change in changes} <= {"operating_mode"}:
        mode = "; an armed run sets its operating mode to 4" if changes else ""
        day.note(passed(servo.leg, f"id {servo.servo_id}: as wanted{mode}; {factory}"))
        return
    words = ", ".join(
        f"{c.name} {in_words(c.name, c.present, model)} instead of {in_words(c.name, c.wanted, model)}"
        for c in changes
    )
    verdict = failed if any(c.name in DANGEROUS for c in changes) else warned
    port = "PORT" if day.site.virtual else day.site.name
    advice = f"bigant servo setup --port {port} --id {servo.servo_id}"
    day.note(verdict(servo.leg, f"id {servo.servo_id}: {words}; {factory}", advice))


def _gap_findings(day: Day, servos: list[CheckedServo]) -> Iterator[Finding]:
    seen: dict[str, list[str]] = {}
    for servo in servos:
        for address, length in gaps(servo.table):
            answer = servo.packets.read(servo.servo_id, address, length)
            if answer.data is not None:
                kind = "other bytes" if any(answer.data) else "zeros"
            else:
                kind = "error" if answer.error else "no answer"
            seen.setdefault(kind, []).append(
                f"id {servo.servo_id}: {address} to {address + length - 1}"
            )
    reads = sum(map(len, seen.values()))
    if len(seen) == 1 and set(seen) <= {"zeros", "error"}:
        kind = next(iter(seen))
        how = f"{reads} reads of the gaps between registers, {len(servos)} servos"
        day.settled("servo", "reserved", kind, how)
        yield passed("gaps", f"{reads} reads between the registers give {kind}")
        return
    words = "; ".join(f"{kind} ({len(where)}, first {where[0]})" for kind, where in seen.items())
    yield warned("gaps", words, "the bytes are in the step's log; nothing of ours reads them")
