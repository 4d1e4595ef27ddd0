"""The numbers of a tick as a viewer plots them: topic by topic, SI units in the names. Pure.

What is not known is left out of its message, so that a curve has a gap there and not a zero.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import Estimate, Health
from model.values.faults import StopReason
from model.values.tick import Tick

VELOCITY = ("vx_m_s", "vy_m_s", "yaw_rate_rad_s")
FORCE = ("x_n", "y_n", "z_n")
SERVO = ("angle_rad", "sent_rad", "rate_rad_s", "current_a", "temperature_c", "voltage_v")
STATE_TEXTS = ("mode", "stop_reason")
ESTIMATE_TEXTS = ("health", "reason")
ESTIMATE = ("x_m", "y_m", "yaw_rad", "x_sd_m", "y_sd_m", "yaw_sd_rad", "nis", "rejects")
STATE = ("late_ms", "busy_ms", "missed", "faults", "gait_phase")


@dataclass(frozen=True, slots=True)
class Numbers:
    """One message: dotted field names and what they are worth, a number or a text."""

    topic: str
    values: tuple[tuple[str, float | str], ...]


@dataclass(frozen=True, slots=True)
class News:
    """Something that happened: a change of mode or of health, or a fault that was not there a tick ago."""

    source: str
    text: str
    fault: bool


def numbers_of(tick: Tick, names: tuple[str, ...]) -> Iterator[Numbers]:
    """Yield all messages of a tick.

    Args:
        tick: The tick.
        names: Leg names.
    """
    predicted = tick.contact.traction.velocity_B
    values = _known("predicted", VELOCITY, predicted)
    estimate = tick.estimate
    if estimate is not None:
        values += _known("estimated", VELOCITY, estimate.velocity_B)
    truth = tick.inputs.truth
    if truth is not None:
        true = np.array([*truth.velocity_B[:2], truth.angular_velocity_B[2]])
        values += _known("true", VELOCITY, true)
        values += _known("difference", VELOCITY, predicted - true)
    yield Numbers("/velocity", values)
    joints, measured = tick.joints, tick.forces.force_n
    modelled = tick.contact.traction.force_B
    for leg, name in enumerate(names):
        yield Numbers(
            f"/force/{name}",
            _known("measured", FORCE, measured[leg])
            + _known("predicted", FORCE, modelled[leg])
            + _known("difference", FORCE, modelled[leg] - measured[leg]),
        )
        shaft = np.array([
            joints.angle_rad[leg], tick.sent.angle_rad[leg], joints.rate_rad_s[leg],
            joints.current_a[leg], joints.temperature_c[leg], joints.voltage_v[leg],
        ])  # fmt: skip
        yield Numbers(f"/servo/{name}", _known("", SERVO, shaft))
    if estimate is not None:
        yield _estimate(estimate)
    timing = tick.inputs.timing
    state = np.array([
        timing.lateness_ns * 1e-6, timing.busy_ns * 1e-6, timing.missed, len(tick.faults),
        tick.gait_phase,
    ])  # fmt: skip
    texts = zip(STATE_TEXTS, (tick.mode.name, tick.stop_reason.name), strict=True)
    yield Numbers("/state", (*texts, *_known("", STATE, state)))


def _estimate(estimate: Estimate) -> Numbers:
    sd = np.sqrt(np.diagonal(estimate.pose_covariance))
    values = np.array([*estimate.position_m, estimate.yaw_rad, *sd, estimate.nis, estimate.rejects])
    texts = zip(ESTIMATE_TEXTS, (estimate.health.value, estimate.reason), strict=True)
    return Numbers("/estimate", (*texts, *_known("", ESTIMATE, values)))


def fields_of(topic: str) -> tuple[tuple[str, bool], ...]:
    """Return the fields that a topic's messages may have, and whether they are texts."""
    if topic == "/state":
        return (*((name, True) for name in STATE_TEXTS), *((name, False) for name in STATE))
    if topic == "/estimate":
        texts = tuple((name, True) for name in ESTIMATE_TEXTS)
        return (*texts, *((name, False) for name in ESTIMATE))
    if topic == "/velocity":
        return _grouped(("predicted", "true", "difference", "estimated"), VELOCITY)
    if topic.startswith("/force/"):
        return _grouped(("measured", "predicted", "difference"), FORCE)
    return tuple((name, False) for name in SERVO)


def _grouped(groups: tuple[str, ...], names: tuple[str, ...]) -> tuple[tuple[str, bool], ...]:
    return tuple((f"{group}.{name}", False) for group in groups for name in names)


def _known(
    group: str, fields: tuple[str, ...], values: FloatArray
) -> tuple[tuple[str, float | str], ...]:
    prefix = f"{group}." if group else ""
    return tuple(
        (prefix + name, float(value))
        for name, value in zip(fields, values, strict=True)
        if np.isfinite(value)
    )


class NewsTracker:
    """Tells what is new in each tick."""

    def __init__(self) -> None:
        self._mode = ""
        self._reason = StopReason.NONE
        self._health = Health.OK
        self._faults: set[tuple[str, str]] = set()

    def news_of(self, tick: Tick) -> tuple[News, ...]:
        """Return what this tick has that the one before had not."""
        news = []
        if tick.mode.name != self._mode:
            self._mode = tick.mode.name
            news.append(News("mode", self._mode, fault=False))
        if tick.stop_reason is not self._reason:
            self._reason = tick.stop_reason
            news.append(News("stopping", self._reason.name, fault=False))
        estimate = tick.estimate
        if estimate is not None and estimate.health is not self._health:
            self._health = estimate.health
            words = estimate.health.value + (f": {estimate.reason}" if estimate.reason else "")
            news.append(News("estimate", words, fault=False))
        now = {(fault.kind.name, fault.source) for fault in tick.faults}
        news += [
            News(fault.source, f"{fault.kind.name}: {fault.detail}", fault=True)
            for fault in tick.faults
            if (fault.kind.name, fault.source) not in self._faults
        ]
        self._faults = now
        return tuple(news)
