"""A cause that was found, as a value, and how it is named in a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gap.diagnosis.comparison.trend import Trend
from gap.interfaces import Cause, place_words
from gap.residuals.vibration import ChannelVibration
from gap.rounding import count_words, value_words

JOINTS_SHOWN = 3  # of a cause at every joint, in a sentence


@dataclass(frozen=True, slots=True)
class Value:
    """One fitted number with its standard error.

    On its bound the effect is not of this form; at ``neutral`` nothing happens.
    """

    name: str
    unit: str
    value: float
    error: float
    neutral: float
    on_bound: bool


@dataclass(frozen=True, slots=True)
class NamedCause:
    """A cause that was found.

    Attributes:
        effect: Its name; of all its forms the same.
        joints: Where; empty for the whole machine.
        form: Name in the catalogue: ``effect``, or the one of its forms that fits best.
        nats: How much better held-out blocks are predicted with it.
        shrink: Its part of what the causes close together on held-out trials; NaN if not measured.
        alone: What it closes by itself.
        last: What it adds to the others.
        remedy: What to check or change.
        trend: How its size changes in the course of a run.
        clear: Probability that its size is not one of nothing, as far as it is from neutral; of one that
            surely vibrates, that its vibration is not one of nothing.
        vibration: What vibrates, if that tells it from another effect; None otherwise.
        p: Its chance in a healthy machine, among all causes that were tried; 0 without references.
    """

    effect: str
    joints: tuple[str, ...]
    stage: str
    values: tuple[Value, ...]
    probability: float
    nats: float
    nats_error: float
    shrink: float
    alone: float
    last: float
    physics: str
    remedy: str
    form: str
    trend: Trend
    clear: float
    vibration: ChannelVibration | None = None
    p: float = 0.0

    @property
    def form_words(self) -> str:
        """Say which form it is of, if not the one that it is named after."""
        return self.form.removeprefix(self.effect).replace("_", " ").strip()

    @property
    def cause(self) -> Cause:
        """Return it as a simulator takes it."""
        return Cause(self.form, self.joints, tuple(one.value for one in self.values))

    @property
    def words(self) -> str:
        """Name the cause with its place and size; of all joints at once, with the largest sizes."""
        sizes = _sizes(self.values)
        if each := self.by_joint:
            shown = list(each.items())[:JOINTS_SHOWN]
            sizes = "; ".join(f"{joint}: {_sizes(own)}" for joint, own in shown)
            if more := len(each) - len(shown):
                sizes += f"; and {count_words(more, 'more joint')}"
        sizes = ", ".join(filter(None, (self.form_words, sizes)))
        return place_words(self.effect, self.joints) + (f" ({sizes})" if sizes else "")

    @property
    def by_joint(self) -> dict[str, tuple[Value, ...]]:
        """Values of a cause of all joints at once, the joint with the largest first; else none."""
        each: dict[str, list[Value]] = {}
        for value in self.values:
            name, at, joint = value.name.partition("@")
            if at:
                each.setdefault(joint, []).append(replace(value, name=name))
        order = sorted(each, key=lambda joint: -abs(each[joint][0].value - each[joint][0].neutral))
        return {joint: tuple(each[joint]) for joint in order}


def names_of(causes: Sequence[NamedCause]) -> str:
    """Name causes, one after the other."""
    *most, last = [one.words for one in causes] or [""]
    return f"{', '.join(most)} and {last}" if most else last


def _sizes(values: Sequence[Value]) -> str:
    return ", ".join(
        f"{v.name} {value_words(v.value, v.error)}" + (" (on its bound)" if v.on_bound else "")
        for v in values
    )
