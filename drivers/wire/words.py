"""Traffic in words: instruction, id, register, value of every frame, for a person who compares two."""

from dataclasses import dataclass

from drivers.ati.packets import Malformed, UnitCommand, parse_command, parse_datagram
from drivers.dynamixel.catalog import EVERY
from drivers.dynamixel.frames import BROADCAST_ID, BadFrame, Frame, FrameParser, Instruction
from model.values.wire import Wire, WireBytes


@dataclass(frozen=True, slots=True)
class Words:
    """One frame.

    Attributes:
        head: What it is: ``sync write goal_position``.
        items: What it says: name and value, for example ``("id 3", "2048")``.
    """

    head: str
    items: tuple[tuple[str, str], ...]

    @property
    def line(self) -> str:
        """All of it in one line."""
        items = ", ".join(f"{name} = {value}" for name, value in self.items)
        return f"{self.head}: {items}" if items else self.head


def wire_words(piece: WireBytes) -> tuple[Words, ...]:
    """Return the frames in a piece of traffic in words."""
    if piece.wire is Wire.SERVO_BUS:
        return _servo_words(piece.data)
    if piece.wire is Wire.FORCE_CONSOLE:
        return (Words(f"console {piece.data.decode('ascii', 'backslashreplace')!r}", ()),)
    return (_command_words(piece.data) if piece.sent else _record_words(piece),)


def difference_words(recorded: WireBytes, sent: WireBytes) -> str:
    """Return in words in what two pieces of traffic differ; empty if words cannot describe it."""
    if recorded.wire is not sent.wire:
        return f"recorded on {wire_name(recorded.wire)}, now on {wire_name(sent.wire)}"
    one, other = wire_words(recorded), wire_words(sent)
    for was, now in zip(one, other, strict=False):
        if was.head != now.head:
            return f"{was.head} recorded, {now.head} now"
        before, after = dict(was.items), dict(now.items)
        changes = [
            f"{name} {before.get(name, 'absent')} recorded, {after.get(name, 'absent')} now"
            for name in {**before, **after}
            if before.get(name) != after.get(name)
        ]
        if changes:
            return f"{was.head}: " + "; ".join(changes)
    if len(one) != len(other):
        return f"{len(one)} frames recorded, {len(other)} now"
    return ""


def wire_name(wire: Wire) -> str:
    """Return the name of a wire for a person."""
    return wire.name.lower().replace("_", " ")


def _servo_words(data: bytes) -> tuple[Words, ...]:
    parser = FrameParser()
    frames = [*parser.feed(data), *parser.give_up()]
    return tuple(_frame_words(frame) for frame in frames)


def _frame_words(frame: Frame | BadFrame) -> Words:
    if isinstance(frame, BadFrame):
        return Words(f"no frame ({frame.reason}) {frame.raw.hex(' ')}", ())
    name = _instruction_name(frame.instruction)
    who = "all" if frame.servo_id == BROADCAST_ID else f"id {frame.servo_id}"
    data = frame.parameters
    if frame.instruction == Instruction.STATUS:
        return Words(f"{name} of {who}", (("error", str(frame.error)), ("data", data.hex(" "))))
    if frame.instruction == Instruction.READ and len(data) == 4:
        return Words(f"{name} {_span_name(data)} of {who}", ())
    if frame.instruction == Instruction.WRITE and len(data) > 2:
        address = int.from_bytes(data[:2], "little")
        return Words(f"{name} to {who}", _values(address, data[2:]))
    if frame.instruction == Instruction.SYNC_READ and len(data) >= 4:
        ids = " ".join(str(i) for i in data[4:])
        return Words(f"{name} {_span_name(data)}", (("ids", ids),))
    if frame.instruction == Instruction.SYNC_WRITE and len(data) >= 4:
        return Words(f"{name} {_span_name(data)}", _sync_values(data))
    return Words(f"{name} to {who}", (("parameters", data.hex(" ")),) if data else ())


def _instruction_name(code: int) -> str:
    try:
        return Instruction(code).name.lower().replace("_", " ")
    except ValueError:
        return f"instruction 0x{code:02x}"


def _span_name(data: bytes) -> str:
    """Name the registers of an address and a length."""
    address, length = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:4], "little")
    names = [r.name for r in EVERY if address <= r.address < address + length]
    if not names:
        return f"{length} bytes from {address}"
    return names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"


def _values(address: int, data: bytes) -> tuple[tuple[str, str], ...]:
    """Name and decode the registers in data that begin at an address."""
    items = []
    at = 0
    while at < len(data):
        register = next((r for r in EVERY if r.address == address + at), None)
        if register is None or at + register.size > len(data):
            items.append((f"bytes from {address + at}", data[at:].hex(" ")))
            break
        items.append((register.name, str(register.decode(data[at : at + register.size]))))
        at += register.size
    return tuple(items)


def _sync_values(data: bytes) -> tuple[tuple[str, str], ...]:
    address, length = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:4], "little")
    items = []
    for at in range(4, len(data), 1 + length):
        values = ", ".join(value for _, value in _values(address, data[at + 1 : at + 1 + length]))
        items.append((f"id {data[at]}", values))
    return tuple(items)


def _command_words(data: bytes) -> Words:
    command = parse_command(data)
    if command is None:
        return Words(f"no command {data.hex(' ')}", ())
    try:
        name = UnitCommand(command.command).name.lower().replace("_", " ")
    except ValueError:
        name = f"command {command.command}"
    return Words(name, (("samples", str(command.samples)),) if len(data) == 10 else ())


def _record_words(piece: WireBytes) -> Words:
    records = parse_datagram(piece.data, piece.t_ns)
    if isinstance(records, Malformed):
        return Words(f"no records ({records.reason}) {piece.data.hex(' ')}", ())
    return Words("records", tuple(("sequence", str(r.sequence)) for r in records))
