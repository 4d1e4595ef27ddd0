"""The numbers of a tick as a viewer plots them: topic by topic, SI units in the names. Pure."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import Estimate, Health
from model.values.faults import StopReason
from model.values.machine_names import MachineNames
from model.values.tick import Tick

VELOCITY = ("vx_m_s", "vy_m_s", "yaw_rate_rad_s")
FORCE = ("x_n", "y_n", "z_n")
# Dotted field names and what they are worth.
Numbers = dict[str, float | str]


@dataclass(frozen=True, slots=True)
class News:
    """Something that happened: a change of mode or of health, or a fault that was not there a tick ago."""

    source: str
    text: str
    fault: bool


def numbers_of(tick: Tick, names: MachineNames) -> Iterator[tuple[str, Numbers]]:
    """Yield topic and message of each group of numbers; every field is there, NaN where it is not known.

    Args:
        tick: The tick.
        names: Names of joints and legs.
    """
    estimate, truth, nothing = tick.estimate, tick.inputs.truth, np.full(3, np.nan)
    predicted = tick.contact.traction.velocity_B
    true = nothing if truth is None else truth.planar_velocity_B
    yield (
        "/velocity",
        {
            **_group("predicted", VELOCITY, predicted),
            **_group("true", VELOCITY, true),
            **_group("difference", VELOCITY, predicted - true),
            **_group("estimated", VELOCITY, nothing if estimate is None else estimate.velocity_B),
        },
    )
    joints, measured, modelled = tick.joints, tick.forces.force_n, tick.contact.traction.force_B
    for leg, name in enumerate(names.legs):
        yield (
            f"/force/{name}",
            {
                **_group("measured", FORCE, measured[leg]),
                **_group("predicted", FORCE, modelled[leg]),
                **_group("difference", FORCE, modelled[leg] - measured[leg]),
            },
        )
    for at, name in enumerate(names.joints):
        yield (
            f"/servo/{name}",
            {
                "angle_rad": float(joints.angle_rad[at]),
                "sent_rad": float(tick.sent.angle_rad[at]),
                "rate_rad_s": float(joints.rate_rad_s[at]),
                "current_a": float(joints.current_a[at]),
                "temperature_c": float(joints.temperature_c[at]),
                "voltage_v": float(joints.voltage_v[at]),
            },
        )
    if estimate is not None:
        yield "/estimate", _estimate(estimate)
    timing = tick.inputs.timing
    yield (
        "/state",
        {
            "mode": tick.mode.name,
            "stop_reason": tick.stop_reason.name,
            "late_ms": timing.lateness_ns * 1e-6,
            "busy_ms": timing.busy_ns * 1e-6,
            "missed": float(timing.missed),
            "faults": float(len(tick.faults)),
            "gait_phase": tick.gait_phase,
        },
    )


def _estimate(estimate: Estimate) -> Numbers:
    sd = np.sqrt(np.diagonal(estimate.pose_covariance))
    return {
        "health": estimate.health.value,
        "reason": estimate.reason,
        **_group("", ("x_m", "y_m", "yaw_rad"), estimate.pose),
        **_group("", ("x_sd_m", "y_sd_m", "yaw_sd_rad"), sd),
        "nis": estimate.nis,
        "rejects": float(estimate.rejects),
    }


def _group(group: str, fields: Sequence[str], values: FloatArray) -> Numbers:
    names = (f"{group}.{field}" if group else field for field in fields)
    return dict(zip(names, values.tolist(), strict=True))


def known(numbers: Mapping[str, float | str]) -> Numbers:
    """Return a message without what is not known, so that a curve has a gap there and not a zero."""
    return {
        name: value
        for name, value in numbers.items()
        if isinstance(value, str) or math.isfinite(value)
    }


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
