"""A small walker for the estimator's tests, and a world that behaves exactly as the filter believes."""

from dataclasses import dataclass

import numpy as np

from model.estimator.filter import Estimator
from model.estimator.measurements import slip_of_feet
from model.estimator.neighbourhood import neighbourhood
from model.estimator.process import walking
from model.estimator.settings import EstimatorSettings
from model.parameters.robot import ContactParameters
from model.values.arrays import FloatArray
from model.values.estimate import FIXED, SCALE, VELOCITY, OdometryInputs, friction_of
from model.values.legs import FootForces, FootMotion

WEIGHT_N = 60.0
PERIOD_NS = 10_000_000
PLACES = np.array([
    [-0.2, 0.25], [0.0, 0.27], [0.2, 0.25], [-0.2, -0.25], [0.0, -0.27], [0.2, -0.25],
])  # fmt: skip
CERTAIN = np.zeros((FIXED + 12, FIXED + 12))  # a covariance of what nobody doubts
CONTACT = ContactParameters(np.full(6, 2500.0), np.full(6, 0.6), np.zeros((6, 2)))


def feet_at(t_s: float) -> FootMotion:
    """Six feet that always stand and slip: each swings at a speed and phase of its own."""
    phase = 2 * np.pi * (0.2 * t_s + np.arange(6) / 6)
    position = np.zeros((6, 3))
    velocity = np.zeros((6, 3))
    position[:, :2] = PLACES
    position[:, 0] += 0.03 * np.sin(phase)
    position[:, 2] = -0.2 - 0.003 * np.sin(phase + 1.0)
    velocity[:, 0] = -0.03 + 0.03 * 0.4 * np.pi * np.cos(phase)
    velocity[:, 2] = -0.003 * 0.4 * np.pi * np.cos(phase + 1.0)
    return FootMotion(position, velocity)


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Inputs of T ticks, and the true pose and velocity at each, (T, 3)."""

    inputs: tuple[OdometryInputs, ...]
    pose: FloatArray
    velocity: FloatArray
    parameters: FloatArray


def simulate(settings: EstimatorSettings, seed: int, ticks: int, *, forces: bool = True) -> World:
    """Draw a world from the filter's own process and measurement noise."""
    draw = np.random.default_rng(seed)
    estimator = Estimator(CONTACT, WEIGHT_N, settings)
    start = estimator.initial()
    truth = draw.multivariate_normal(start.mean, start.covariance)
    # what the gauge says is so
    truth[friction_of(6)] -= truth[friction_of(6)].mean()
    made, poses, velocities = [], [], []
    for i in range(ticks):
        t_ns = i * PERIOD_NS
        feet = feet_at(t_ns * 1e-9)
        factors = np.exp(truth[FIXED:])
        contact = ContactParameters(
            CONTACT.stiffness * factors[6:], CONTACT.mu * factors[:6], CONTACT.anisotropy
        )
        model = neighbourhood(feet, contact, WEIGHT_N, settings.law, settings.sway_step_s)
        assert model.reason == 0
        if i:
            step = walking(truth, CERTAIN, model, settings, PERIOD_NS * 1e-9, WEIGHT_N, 0)
            root = np.linalg.svd(step.noise, hermitian=True)
            truth = step.mean + root[0] @ (np.sqrt(root[1]) * draw.normal(size=len(truth)))
            truth[friction_of(6)] -= truth[friction_of(6)].mean()
        poses.append(truth[:3].copy())
        velocities.append(truth[VELOCITY].copy())
        share = np.zeros((6, 3))
        noise = settings.load_sd * draw.normal(size=6)
        share[:, 2] = model.load_n / WEIGHT_N + noise - noise.mean()  # the weight is known
        slip = slip_of_feet(truth[VELOCITY], feet, model.sway_B)
        size = np.sqrt((slip**2).sum(axis=1) + settings.creep_speed**2)[:, None]
        mu = contact.mu * np.exp(truth[SCALE])
        share[:, :2] = -(mu * share[:, 2])[:, None] * slip / size
        level = (share[:, :2] ** 2).sum(axis=1, keepdims=True)
        sd = np.sqrt(settings.force_sd**2 + settings.force_share_sd**2 * level)
        share[:, :2] += sd * draw.normal(size=(6, 2))
        heard = FootForces(t_ns, WEIGHT_N * share, np.full(6, forces))
        made.append(OdometryInputs(t_ns, feet, heard if forces else None))
    return World(tuple(made), np.array(poses), np.array(velocities), truth[SCALE:])
