"""A recording as a robot file with effects has it: its feet, forces and model, tick by tick."""

from dataclasses import dataclass

import numpy as np

from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.estimate import AddedByEffects
from model.values.legs import FootForces, FootMotion
from model.values.tick import DeadReckoning
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig
from robot.control.effects import EffectMemory, EffectsBeside
from robot.odometry.track import Progress


@dataclass(frozen=True, slots=True, eq=False)
class EffectFrames:
    """A recording of T ticks of N legs as a robot file with effects has it.

    Attributes:
        feet: (T, N, 3) each.
        weight_n: With what rides along.
        force_n: Forces without what sensors add, (T, N, 3).
        velocity_B: The file's model with its effects, (T, 3).
        force_B: Its forces, (T, N, 3).
        added: What the effects add at each tick of the span.
    """

    feet: FootMotion
    weight_n: float
    force_n: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_B: FloatArray  # noqa: N815
    added: tuple[AddedByEffects, ...]


def effect_frames(
    log: Recording,
    config: RobotConfig,
    settings: EstimatorSettings,
    span: tuple[int, int],
    progress: Progress | None,
) -> EffectFrames | None:
    """Run the file's model over the walking part of a recording; None for a file without effects.

    Args:
        log: The recording.
        config: The robot file.
        settings: Of the estimator; its law of friction.
        span: First tick, and the one after the last.
        progress: Told the share done.
    """
    if not config.effects:
        return None
    first, last = span
    beside = EffectsBeside(config, settings.law)
    position, velocity = np.full((2, *log.force_n.shape), np.nan)
    twist, force = (
        np.full((last - first, 3), np.nan),
        np.full((last - first, *log.force_n.shape[1:]), np.nan),
    )
    true_n = log.force_n.copy()
    added: list[AddedByEffects] = []
    start = DeadReckoning(
        int(log.t_s[first] * 1e9), np.zeros(2), 0.0, np.full(3, np.nan), valid=False
    )
    memory = EffectMemory(int(log.t_s[0] * 1e9), start)
    for i in range(first, last):
        reading = FootForces(0, log.force_n[i], np.isfinite(log.force_n[i]).all(axis=1))
        memory, tick = beside.step(
            memory, int(log.t_s[i] * 1e9), log.angle_rad[i], log.rate_rad_s[i], reading
        )
        feet, traction = tick.answer.feet, tick.answer.contact.traction
        true_n[i] = tick.forces.force_n
        position[i], velocity[i] = feet.position_m, feet.velocity_m_s
        twist[i - first], force[i - first] = traction.velocity_B, traction.force_B
        added.append(tick.added)
        if progress is not None and i % 200 == 0:
            progress((i - first) / (last - first))
    return EffectFrames(
        FootMotion(position, velocity), beside.weight_n, true_n, twist, force, tuple(added)
    )
