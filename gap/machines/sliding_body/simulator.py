"""One rigid body sliding on level ground under its own friction, as a simulator under diagnosis.

Its nominal law is viscous (drag grows with speed: mu g v at a speed v in m/s) or Coulomb's (mu g against
the motion). Stages fed measured inputs get the measured velocity; fed commands, the body is let go with
the velocity it was first seen with.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import tomlkit

from gap.data.columns import Sign, faults_of
from gap.data.even_grid import even_times, on_times
from gap.interfaces import Cause, Channel, DataFault, Drive, Effect, Observation, check_causes
from gap.machine_kinds import MachineKind
from gap.machines.sliding_body.catalogue import CATALOGUE, STAGES
from gap.rounding import count_words
from model.compiled import compiled
from model.errors import ConfigError, GapError
from model.motion.filters import at_times
from model.parameters.tables import parse_table
from model.values.arrays import FloatArray, readonly
from model.values.gravity import STANDARD_GRAVITY
from record.trial.trial import Trial

WINDOW_S = 0.08
ORDER = 2
REST_M_S = 0.03  # slower than this a body is about to stick, and a direction means little
ASSUMED_POSITION_M = 0.0005
SUBSTEPS = 4
# Deceleration along the path, acceleration across it, and speed.
CHANNELS = (
    Channel("deceleration", "", "friction", "m/s^2"),
    Channel("sideways", "", "friction", "m/s^2"),
    Channel("speed", "", "friction", "m/s"),
)


class SlidingLaw(NamedTuple):
    """Friction (Coulomb's law or the viscous one, mu and its change with speed), slope, delay of poses."""

    coulomb: bool
    mu: float
    per_m_s: float = 0.0
    slope_x: float = 0.0
    slope_y: float = 0.0
    delay_s: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Slide:
    """A trial on even frames.

    Attributes:
        time_s: (F,).
        period_s: Between frames.
        position_m: Horizontal, (F, 2).
        velocity_m_s: (F, 2), smoothed.
        window: Frames of the smoothing filter.
    """

    time_s: FloatArray
    period_s: float
    position_m: FloatArray
    velocity_m_s: FloatArray
    window: int


@compiled
def _friction(v: FloatArray, law: SlidingLaw) -> FloatArray:
    speed = np.sqrt(v[0] * v[0] + v[1] * v[1])
    level = law.mu * max(1.0 + law.per_m_s * speed, 0.0) * STANDARD_GRAVITY
    if law.coulomb:
        level = level / max(speed, 1e-9)
    pull: FloatArray = -level * v
    return pull


@compiled
def _coast(frames: int, dt: float, start: FloatArray, law: SlidingLaw) -> FloatArray:
    """Let a body go, (F, 2) velocities; dry friction stops it and does not turn it round."""
    out = np.empty((frames, 2))
    v = start.copy()
    h = dt / SUBSTEPS
    slope = np.array([law.slope_x, law.slope_y])
    for i in range(frames):
        out[i] = v
        for _ in range(SUBSTEPS):
            pull = -STANDARD_GRAVITY * slope
            step = h * (_friction(v, law) + pull)
            speed = np.sqrt(v[0] * v[0] + v[1] * v[1])
            if law.coulomb and speed < h * STANDARD_GRAVITY * law.mu:
                held = np.sqrt(pull[0] ** 2 + pull[1] ** 2) <= law.mu * STANDARD_GRAVITY
                v = 0.0 * pull if held else h * pull
            else:
                v = v + step
    return out


class SlidingBody:
    """Implements ``gap.interfaces.Simulator`` for one sliding body with its nominal law."""

    name = "sliding_body"
    stages = STAGES
    joints: tuple[str, ...] = ()
    bodies = ("body",)
    effects = CATALOGUE
    channels = CHANNELS

    def __init__(self, law: SlidingLaw) -> None:
        self.law = law
        self._slide = lru_cache(maxsize=1024)(_slide)

    def observe(self, trial: Trial) -> Observation:
        """Put the measured data of a trial on the channels.

        Raises:
            GapError: The trial has no body positions, or is too short.
        """
        slide = self._slide(trial)
        values = _channels(slide, slide.velocity_m_s)
        given = trial.header.noise.body_position_m
        position = given if np.isfinite(given) and given > 0 else ASSUMED_POSITION_M
        # a straight line through the window of positions, then another through the slopes
        slope = position / (slide.period_s * np.sqrt((slide.window**3 - slide.window) / 12))
        noise = np.array([2.0 * slope / (slide.window * slide.period_s)] * 2 + [slope])
        weight = np.ones(values.shape)
        speed = np.linalg.norm(slide.velocity_m_s, axis=1)
        weight[speed < REST_M_S] = 0.0
        edge = slide.window // 2
        weight[:edge] = 0.0
        weight[len(weight) - edge :] = 0.0
        frames = len(slide.time_s)
        return Observation(
            time_s=readonly(slide.time_s.copy()),
            cycle=readonly(np.full(frames, np.nan)),
            values=readonly(values),
            noise=readonly(np.broadcast_to(noise, values.shape).copy()),
            weight=readonly(weight),
        )

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read with these causes added, (F, C).

        Raises:
            GapError: A cause is not of the catalogue, or its values do not fit.
        """
        check_causes(causes, self)
        law = _changed(self.law, causes)
        slide = self._slide(trial)
        edge = slide.window // 2
        start = slide.velocity_m_s[edge]
        if drive is Drive.COMMAND:
            v = _coast(len(slide.time_s), slide.period_s, start, law)
            velocity = np.concatenate([np.repeat(v[:1], edge, axis=0), v])[: len(v)]
        else:
            rate = np.array([_friction(v, law) for v in slide.velocity_m_s])
            rate = rate - STANDARD_GRAVITY * np.array([law.slope_x, law.slope_y])
            steps = 0.5 * (rate[1:] + rate[:-1]) * slide.period_s
            grown = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
            velocity = start + grown - grown[edge]
        if law.delay_s > 0.0:
            velocity = at_times(slide.time_s, velocity, slide.time_s - law.delay_s)
        return np.asarray(readonly(_channels(slide, velocity)))

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Look for faults of the data themselves."""
        return tuple(faults_of("body", _faults(trial)))


def _faults(trial: Trial) -> Iterator[Sign]:
    xy = trial.body_position_m[:, :2]
    if not len(xy):
        return
    lost = float(np.mean(~np.isfinite(xy).all(axis=1)))
    if lost > 0.0:
        yield "gap", f"{lost:.1%} of poses are missing", lost > 0.2
    speed = np.linalg.norm(np.diff(xy, axis=0), axis=1) / np.diff(trial.time_s)
    speed = speed[np.isfinite(speed)]
    if not len(speed):
        return
    jumps = int(np.sum(speed > 30 * max(float(np.median(speed)), 0.05)))
    if jumps:
        yield "spikes", f"{count_words(jumps, 'jump')} of the position", True
    if speed.max() > 50.0:
        yield "unit", f"speeds up to {speed.max():.3g} m/s: millimetres?", True


def _changed(law: SlidingLaw, causes: Sequence[Cause]) -> SlidingLaw:
    level = 1.0
    for cause in causes:
        values = cause.values
        if cause.effect == "coulomb_friction":
            law = law._replace(coulomb=True, mu=values[0])
        elif cause.effect == "speed_dependence":
            law = law._replace(per_m_s=law.per_m_s + values[0])
        elif cause.effect == "friction_level":
            level *= values[0]
        elif cause.effect == "ground_slope":
            law = law._replace(slope_x=law.slope_x + values[0], slope_y=law.slope_y + values[1])
        elif cause.effect == "pose_delay":
            law = law._replace(delay_s=law.delay_s + values[0])
    return law._replace(mu=law.mu * level)


def _slide(trial: Trial) -> Slide:
    from scipy.signal import savgol_filter  # a third of a second: as late as it is needed

    xy = trial.body_position_m[:, :2]
    known = np.isfinite(xy).all(axis=1)
    if known.mean() < 0.8:
        raise GapError("body_x_m and body_y_m are mostly empty; a sliding body needs its positions")
    at_s = even_times(trial)
    position = on_times(trial.time_s[known], xy[known], at_s)
    period = float(at_s[1] - at_s[0])
    window = max(2 * round((WINDOW_S / period - 1) / 2) + 1, 5)
    velocity = savgol_filter(position, window, ORDER, deriv=1, delta=period, axis=0)
    return Slide(at_s - at_s[0], period, position, np.asarray(velocity), window)


def _channels(slide: Slide, velocity: FloatArray) -> FloatArray:
    """Acceleration along and across the measured path, and speed along it, (F, 3)."""
    from scipy.signal import savgol_filter

    rate = savgol_filter(velocity, slide.window, ORDER, deriv=1, delta=slide.period_s, axis=0)
    speed = np.linalg.norm(slide.velocity_m_s, axis=1)
    along = slide.velocity_m_s / np.maximum(speed, 1e-9)[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    return np.column_stack([
        -np.sum(rate * along, axis=1),
        np.sum(rate * across, axis=1),
        np.sum(velocity * along, axis=1),
    ])  # fmt: skip


def sliding_body(trials: Sequence[Trial]) -> SlidingBody:
    """Return the simulator of the body that the trials name.

    Raises:
        GapError: Its file cannot be used.
    """
    return SlidingBody(_law(trials[0].header.robot_text))


def _law(text: str) -> SlidingLaw:
    """Read the body's file."""
    try:
        top = parse_table(text)
        contact, ground = top.maybe_table("contact"), top.maybe_table("ground")
        name = contact.maybe_text("law") or "viscous"
        law = SlidingLaw(
            name == "coulomb",
            contact.number("mu", minimum=0.0, otherwise=0.2),
            contact.number("per_m_s", otherwise=0.0),
            ground.number("slope_x", otherwise=0.0),
            ground.number("slope_y", otherwise=0.0),
            top.maybe_table("sensing").number("pose_delay_s", minimum=0.0, otherwise=0.0),
        )
    except ConfigError as error:
        raise GapError(f"the machine's file cannot be used: {error}") from error
    if name not in {"viscous", "coulomb"}:
        raise GapError(f"contact.law must be viscous or coulomb, not {name!r}")
    return law


def with_causes(text: str, causes: Sequence[Cause], effects: Sequence[Effect]) -> str:
    """Write causes into the body's file: [contact], [ground] and [sensing]; all else stays.

    Raises:
        GapError: The file cannot be used.
    """
    del effects  # each has its keys
    law = _changed(_law(text), causes)
    document = tomlkit.parse(text)
    tables: dict[str, dict[str, str | float]] = {
        "contact": {
            "law": "coulomb" if law.coulomb else "viscous",
            "mu": law.mu,
            "per_m_s": law.per_m_s,
        },
        "ground": {"slope_x": law.slope_x, "slope_y": law.slope_y},
        "sensing": {"pose_delay_s": law.delay_s},
    }
    for name, keys in tables.items():
        if name not in document and not any(keys.values()):
            continue
        table = document.setdefault(name, tomlkit.table())
        for key, value in keys.items():
            if value or key in table:
                table[key] = value
    return tomlkit.dumps(document)


BODY = MachineKind(
    sliding_body,
    apply=with_causes,
    no_propose="is let go by hand: push it faster, slower and along other directions of the ground",
)
