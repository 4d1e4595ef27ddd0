"""A tick encoded by its form is the message of ``encode_tick``, byte for byte."""

from dataclasses import replace

import numpy as np
import pytest

from model.values.tick import Tick
from record.log import tick_message
from record.log.tick_message import TickEncoder, encode_tick, encoder_like
from tests.record.ticks import make_tick


def plain_tick(index: int, legs: int = 6) -> Tick:
    """A tick full of random numbers with no faults, poses or readings of an IMU."""
    for further in range(1000):
        tick = make_tick(index + 100 * further, legs=legs)
        if tick.estimate is not None:
            inputs = replace(tick.inputs, faults=(), poses=(), imu=())
            return replace(tick, inputs=inputs, faults=())
    raise AssertionError("no tick has an estimate")


def with_texts(tick: Tick, gait: str, reason: str) -> Tick:
    assert tick.estimate is not None
    request = replace(tick.inputs.request, gait=gait)
    support = replace(tick.contact.support, reason=reason)
    return replace(
        tick,
        inputs=replace(tick.inputs, request=request),
        contact=replace(tick.contact, support=support),
        estimate=replace(tick.estimate, remark=2 * reason),
    )


@pytest.mark.parametrize(
    ("legs", "estimate"),
    [
        (6, True), (6, False), (1, True),
        *(pytest.param(*case, marks=pytest.mark.soak)
          for case in ((1, False), (3, True), (3, False), (9, True), (9, False))),
    ],
)  # fmt: skip
def test_ticks_of_a_form_have_the_bytes_of_any_tick(legs: int, estimate: bool) -> None:
    encoders: dict[tuple[int, ...], tick_message.Encoder] = {}
    for index in range(60):
        tick = plain_tick(index, legs)
        if not estimate:
            tick = replace(tick, estimate=None)
        form = tick_message._form_of(tick)
        assert form is not None
        key, texts = form
        encoder = encoders.setdefault(key, encoder_like(tick))
        made = encoder(tick, texts)
        assert made is None or made == encode_tick(tick)
        assert encoder_like(tick)(tick, texts) == encode_tick(tick)


@pytest.mark.parametrize(
    ("gait", "reason"), [("", ""), ("tripod", "gone"), ("gähn", "übel ist"), ("a" * 60, "b" * 9)]
)
def test_texts_of_any_length(gait: str, reason: str) -> None:
    example = with_texts(plain_tick(3), gait, reason)
    form = tick_message._form_of(example)
    assert form is not None
    assert encoder_like(example)(example, form[1]) == encode_tick(example)
    longer = with_texts(plain_tick(3), gait + 8 * "x", reason + 16 * "y")
    other = tick_message._form_of(longer)
    assert other is not None
    assert other[0] == form[0]
    assert encoder_like(example)(longer, other[1]) == encode_tick(longer)


def test_arrays_of_another_length_or_kind_are_refused() -> None:
    example = plain_tick(2)
    form = tick_message._form_of(example)
    assert form is not None
    encoder, texts = encoder_like(example), form[1]
    assert encoder(example, texts) is not None
    for joints in (
        replace(example.joints, duty=np.zeros(5)),
        replace(example.joints, duty=np.zeros(6, dtype=np.float32)),
        replace(example.joints, duty=np.zeros(6, dtype=np.int64)),
        replace(example.joints, valid=np.zeros(6)),  # type: ignore[arg-type]
    ):
        assert encoder(replace(example, joints=joints), texts) is None


def test_a_tick_without_an_estimate_has_another_form() -> None:
    example = plain_tick(2)
    form, bare = (
        tick_message._form_of(tick) for tick in (example, replace(example, estimate=None))
    )
    assert form is not None
    assert bare is not None
    assert len(bare[0]) < len(form[0])


def test_sequences_that_may_vary() -> None:
    example = plain_tick(2)
    assert example.estimate is not None
    form = tick_message._form_of(example)
    assert form is not None
    for rows in (1, 2, 7, 30):
        estimate = replace(
            example.estimate, innovation=np.random.default_rng(rows).normal(size=(rows, 3))
        )
        tick = replace(example, estimate=estimate)
        if len(example.estimate.innovation):
            assert encoder_like(example)(tick, form[1]) == encode_tick(tick)


def test_an_encoder_of_a_log_takes_any_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tick_message, "WORTH_IT", 2)
    monkeypatch.setattr(tick_message, "MOST_FORMS", 20)
    encoder = TickEncoder()
    ticks = [make_tick(index) for index in range(60)] + [
        plain_tick(index % 9) for index in range(60)
    ]
    for tick in (*ticks, *ticks):
        assert encoder.encode(tick) == encode_tick(tick)
    assert encoder._forms
