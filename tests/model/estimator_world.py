"""A small walker for the estimator's tests, and a world that behaves exactly as the filter believes."""

from dataclasses import dataclass, replace

import numpy as np

from model.estimator.filter import Estimator
from model.estimator.neighbourhood import Neighbourhood, neighbourhood
from model.estimator.process import walking
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.tolerance_kernel import OTHERS, tolerance_kernel
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.estimate import FIXED, SCALE, VELOCITY, Estimate, EstimatorState, OdometryInputs
from model.values.legs import FootForces, FootMotion
from model.values.parameters import ContactParameters

WEIGHT_N = 60.0
PERIOD_NS = 10_000_000
PLACES = np.array([
    [-0.2, 0.25], [0.0, 0.27], [0.2, 0.25], [-0.2, -0.25], [0.0, -0.27], [0.2, -0.25],
])  # fmt: skip
CERTAIN = np.zeros((FIXED + 12, FIXED + 12))  # a covariance of what nobody doubts
SETTINGS = EstimatorSettings()
CONTACT = ContactParameters(np.full(6, 2500.0), np.full(6, 0.6), np.zeros((6, 2)))


def friction_of(legs: int) -> slice:
    """Where log mu of all legs stands in the state."""
    return slice(FIXED, FIXED + legs)


def stiffness_of(legs: int) -> slice:
    """Where log K of all legs stands in the state."""
    return slice(FIXED + legs, FIXED + 2 * legs)


def slip_of_feet(velocity: FloatArray, feet: FootMotion, sway: FloatArray) -> FloatArray:
    """Velocity of each foot over the ground, (N, 2) [m/s].

    Args:
        velocity: Of the body origin, (3,).
        feet: (N, 3) each.
        sway: Part of it that comes from tilting over the feet, (2,).
    """
    slip = feet.velocity_m_s[:, :2] + (velocity[:2] - sway)
    slip[:, 0] -= velocity[2] * feet.position_m[:, 1]
    slip[:, 1] += velocity[2] * feet.position_m[:, 0]
    return slip


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


def simulate(
    settings: EstimatorSettings,
    seed: int,
    ticks: int,
    *,
    forces: bool = True,
    contact: ContactParameters = CONTACT,
) -> World:
    """Draw a world from the filter's own process and measurement noise, about this contact."""
    draw = np.random.default_rng(seed)
    estimator = Estimator(contact, WEIGHT_N, settings)
    start = estimator.initial()
    record = record_of(settings, WEIGHT_N)
    truth = draw.multivariate_normal(start.mean, start.covariance)
    # what the gauge says is so
    truth[friction_of(6)] -= truth[friction_of(6)].mean()
    # a robot that differs from the file by its tolerances
    errors = draw.normal(size=(1, 6 + OTHERS))
    own_twist, own_rest = np.full((1, 3), np.nan), np.zeros((1, 6), dtype=bool)
    moved, apart, more = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 6))
    made, poses, velocities = [], [], []
    for i in range(ticks):
        t_ns = i * PERIOD_NS
        feet = feet_at(t_ns * 1e-9)
        model = neighbourhood(truth, feet, contact, record)
        assert model is not None
        tolerance_kernel(
            truth, feet.position_m, feet.velocity_m_s, contact.stiffness, contact.mu,
            contact.anisotropy, record, model.rows[0], model.slip_B,
            model.sway_B, errors, PERIOD_NS * 1e-9,
            own_twist, own_rest, moved, apart, more, np.zeros((3, 3)),
        )  # fmt: skip
        loads = model.load_n + WEIGHT_N * more[0]
        model.rows[0, :3] += apart[0]
        if i:
            step = walking(truth, CERTAIN, model, record, PERIOD_NS * 1e-9)
            root = np.linalg.svd(step.noise, hermitian=True)
            truth = step.mean + root[0] @ (np.sqrt(root[1]) * draw.normal(size=len(truth)))
            truth[friction_of(6)] -= truth[friction_of(6)].mean()
        poses.append(truth[:3].copy())
        velocities.append(truth[VELOCITY].copy())
        share = np.zeros((6, 3))
        noise = settings.load_sd * draw.normal(size=6)
        share[:, 2] = loads / WEIGHT_N + noise - noise.mean()  # the weight is known
        slip = slip_of_feet(truth[VELOCITY], feet, model.sway_B)
        size = np.sqrt((slip**2).sum(axis=1) + settings.creep_speed**2)[:, None]
        mu = contact.mu * np.exp(truth[SCALE] + truth[friction_of(6)])
        share[:, :2] = -(mu * share[:, 2])[:, None] * slip / size
        level = (share[:, :2] ** 2).sum(axis=1, keepdims=True)
        sd = np.sqrt(settings.force_sd**2 + settings.force_share_sd**2 * level)
        share[:, :2] += sd * draw.normal(size=(6, 2))
        heard = FootForces(t_ns, WEIGHT_N * share, np.full(6, forces))
        made.append(OdometryInputs(t_ns, feet, heard if forces else None))
    return World(tuple(made), np.array(poses), np.array(velocities), truth[SCALE:])


def run(
    inputs: list[OdometryInputs],
    settings: EstimatorSettings = SETTINGS,
    contact: ContactParameters = CONTACT,
) -> tuple[list[EstimatorState], list[Estimate]]:
    """Step the estimator through inputs; return its states and estimates."""
    estimator = Estimator(contact, WEIGHT_N, settings)
    state = estimator.initial()
    states, said = [], []
    for known in inputs:
        state, estimate = estimator.step(state, known)
        states.append(state)
        said.append(estimate)
    return states, said


def solved(
    mean: FloatArray, feet: FootMotion, law: FrictionLaw = FrictionLaw.COULOMB
) -> Neighbourhood:
    """Return the model's answer with its derivatives, forces without the ansatz."""
    settings = replace(SETTINGS, law=law, rest_speed=0.0)
    answer = neighbourhood(mean, feet, CONTACT, record_of(settings, WEIGHT_N))
    assert answer is not None
    return answer
