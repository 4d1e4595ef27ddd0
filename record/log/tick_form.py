"""Ticks that are like many before them, encoded in one go; ``record.log.tick_message`` encodes any tick.

Both give the same bytes (``tests/record/test_tick_form.py``). A tick with a fault, a pose or a reading of
an IMU has no form here.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import TypeAlias

from model.values.tick import Tick
from record.log.cdr import text_bytes
from record.log.estimate_message import BEFORE_SOURCES, SCOPE, SOURCES
from record.log.fields import Part
from record.log.message_form import FormSource
from record.log.tick_message import (
    DEAD_RECKONING,
    FEET,
    FORCE_RECORD,
    FORCES,
    JOINTS,
    REQUEST,
    SENT,
    SERVOS,
    SUPPORT,
    TIMING,
    TRACTION,
    TRUTH,
    WISHED,
    encode_tick,
    no_servos,
    no_truth,
)

Encoder: TypeAlias = Callable[[Tick, tuple[bytes, ...]], bytes | None]
# A form is worked out when so many ticks have had it, which takes as long as encoding fifty of them.
WORTH_IT = 50
MOST_FORMS = 64
MOST_RECORDS = 4
VARYING = frozenset({"estimate.innovation", "estimate.source_nis", "estimate.source_dof"})


class TickEncoder:
    """Encodes the ticks of one log."""

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
    if estimate is None or lists or len(inputs.forces) > MOST_RECORDS:
        return None
    texts = (
        text_bytes(inputs.request.gait), text_bytes(contact.support.reason),
        text_bytes(contact.traction.reason), text_bytes(estimate.reason),
        text_bytes(estimate.remark),
    )  # fmt: skip
    key = (
        len(inputs.forces), len(tick.wished.angle_rad), len(tick.feet.position_m),
        len(estimate.innovation) > 0, len(estimate.source_nis) > 0, len(estimate.source_dof) > 0,
        *[len(text) & 7 for text in texts],
    )  # fmt: skip
    return key, texts


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
    source = FormSource(scope, VARYING)

    def add(name: str, parts: Sequence[Part]) -> None:
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
    source.numbers("I", "1")
    add("estimate", (*BEFORE_SOURCES, *SOURCES))
    return source.made("tick, texts", before)
