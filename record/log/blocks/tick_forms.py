"""The forms of a log's ticks: which can be read as columns, and which are taken apart one by one."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray, IntArray
from model.values.faults import FaultKind, StopReason
from model.values.machine_names import MachineNames
from model.values.tick import Intent, Mode
from record.log.blocks.message_form import Columns, MessageForm, form_of
from record.log.estimate_message import HEALTHS
from record.log.tick_message import TICK_DEFINITIONS, decode_tick

TICK = "bigant_msgs/Tick"
MOST_FORMS = 64  # new ones in a block; of what is left each tick is taken apart by itself
FEWEST = 4  # messages of one form that are worth finding it
# Codes that a message may have: all others are damage.
_CODES = {
    "mode": range(len(Mode)),
    "stop_reason": range(len(StopReason)),
    "request_intent": range(len(Intent)),
    "request_reason": range(len(StopReason)),
    "estimate.0.health": range(len(HEALTHS)),
}
_FAULT_CODES = range(1, 1 + len(FaultKind))


class FormBook:
    """The forms of a log's ticks that were met so far."""

    def __init__(self) -> None:
        self._forms: dict[int, list[MessageForm]] = {}

    def groups(
        self, messages: Sequence[bytes], machine: MachineNames
    ) -> Iterator[tuple[IntArray, Columns]]:
        """Yield the numbers of messages of one form, and the messages; what is unusual is left out.

        Args:
            messages: Ticks of today's layout.
            machine: Whose joints and legs they have to have.
        """
        sizes = np.array([len(data) for data in messages])
        new = 0
        for size in sorted(set(sizes.tolist())):
            places = np.flatnonzero(sizes == size)
            if len(places) < FEWEST or not size:
                continue
            data = b"".join([messages[place] for place in places.tolist()])
            table = np.frombuffer(data, np.uint8).reshape(-1, size)
            left = np.ones(len(places), dtype=bool)
            known = self._forms.setdefault(size, [])
            for form in known:
                fits = left & form.fits(table) if left.any() else left
                left &= ~fits
                yield from _group(form, places, table, fits)
            while left.any() and new < MOST_FORMS:
                new += 1
                first = int(np.argmax(left))
                first_form = _usable(table[first].tobytes(), machine)
                left[first] = False
                if first_form is not None:
                    known.append(first_form)
                    left[first] = True
                    fits = left & first_form.fits(table)
                    left &= ~fits
                    yield from _group(first_form, places, table, fits)


def _usable(data: bytes, machine: MachineNames) -> MessageForm | None:
    """Return the form of a tick; None if it is unusual: other legs, damage."""
    try:
        form = form_of(data, TICK_DEFINITIONS, TICK)
        tick = decode_tick(data)
    except ValueError:
        return None
    usual = len(tick.joints.angle_rad) == len(machine.joints)
    usual &= all(
        len(feet) == len(machine.legs)
        for feet in (
            tick.forces.force_n, tick.contact.traction.slip_B, tick.contact.traction.force_B,
            *([tick.estimate.force_B] if tick.estimate is not None else []),
            *([tick.inputs.truth.contact] if tick.inputs.truth is not None else []),
        )
    )  # fmt: skip
    return form if usual else None


def _codes(form: MessageForm) -> Iterator[tuple[str, range]]:
    """Yield the fields that hold codes, and the codes there are."""
    yield from ((name, codes) for name, codes in _CODES.items() if name in form.places)
    for name in ("faults", "input_faults"):
        yield from ((f"{name}.{i}.kind", _FAULT_CODES) for i in range(form.counts[name]))


def _group(
    form: MessageForm, places: IntArray, table: NDArray[np.uint8], fits: BoolArray
) -> Iterator[tuple[IntArray, Columns]]:
    if not fits.any():
        return
    columns = Columns(form, table if fits.all() else table[fits])
    places = places[fits]
    sound = columns.plain()
    for name, codes in _codes(form):
        code = columns.of(name)
        sound &= (code >= codes.start) & (code < codes.stop)
    if not sound.all():
        columns, places = Columns(form, table[fits][sound]), places[sound]
    if len(columns):
        yield places, columns
