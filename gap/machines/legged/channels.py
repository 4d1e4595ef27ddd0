"""What is compared: the legged simulator's channels, from sensor signals on the working grid."""

import numpy as np

from gap.constants import (
    CONTACT_N,
    EDGE_S,
    GRIP_NOISE,
    GRIP_READINGS,
    MEAN_READINGS,
    PULL_SHARE,
    PULL_WEIGHT,
    SWITCH_S,
    SWITCH_WEIGHT,
)
from gap.data.gait_phase import gait_cycle
from gap.interfaces import NOWHERE, Channel, Observation
from gap.machines.legged.grip import Windows, grip_of, weight_of_frames
from gap.machines.legged.inputs import LeggedInputs
from gap.machines.legged.mean_motion import MEANS, mean_noise, means_of
from model.compiled import compiled
from model.effects.grid import DOWN, TWIST_WINDOW_S, Grid, body_velocity, placed_noise
from model.effects.signals import SensorSignals
from model.values.arrays import FloatArray, given_rows, readonly
from model.values.machine_names import MachineNames
from record.trial.header import TrialNoise

# Where a trial does not say how noisy its sensors are.
ASSUMED = TrialNoise(0.2, 0.001, 0.002, 0.001, 0.001)
AXES = "xyz"
CHANNELS_OF_BODY = 15  # its pose, velocities and their means, and the total force on all feet
SIDE, MIDDLE = float(DOWN[0]), float(DOWN[1])


def channels(names: MachineNames) -> tuple[Channel, ...]:
    """Return the channels of J joints and N legs, J + 8 N + 15, in the order of ``to_channels``.

    The total force on all feet is known better than that on each: feet that stick push against each other,
    otherwise on each day. It is the weight and what pulls at the robot, and its moment about the body's
    origin says where the weight is. A foot that pulls at the ground does so for a moment, as it comes off:
    what is far below 0 of its force is compared by itself, because how much it carries differs by more.
    """
    legs = names.legs
    return (
        *(Channel("shaft_error", joint, "actuation", "rad") for joint in names.joints),
        *(Channel(f"foot_{a}", leg, "kinematics", "m") for leg in legs for a in AXES),
        *(Channel("force_z", leg, "support", "N") for leg in legs),
        Channel("body_z", "", "support", "m"),
        Channel("roll", "", "support", "rad"),
        Channel("pitch", "", "support", "rad"),
        *(
            Channel(f"force_{a}", leg, "friction", "N", trapped=True)
            for leg in legs
            for a in AXES[:2]
        ),
        Channel("body_vx", "", "dynamics", "m/s"),
        Channel("body_vy", "", "dynamics", "m/s"),
        Channel("body_wz", "", "dynamics", "rad/s"),
        *(Channel(f"total_force_{a}", "", "friction", "N") for a in AXES[:2]),
        Channel("total_force_z", "", "support", "N"),
        *(Channel(f"total_moment_{a}", "", "support", "N m") for a in AXES[:2]),
        Channel("total_moment_z", "", "friction", "N m"),
        *(Channel("pull_z", leg, "support", "N") for leg in legs),
        *(Channel(f"mean_{a}", "", "dynamics", unit, lasting=True) for a, unit in MEANS),
        *(Channel("grip", leg, "friction", "log", lasting=True) for leg in legs),
    )


def to_channels(
    grid: Grid,
    command_rad: FloatArray,
    signals: SensorSignals,
    windows: Windows,
    grip: FloatArray | None = None,
) -> FloatArray:
    """Put signals on the channels, (F, C). The same for measured and predicted signals.

    Args:
        grid: The working grid.
        command_rad: As logged, (W, J).
        signals: W frames of J joints and N legs.
        windows: In which what lasts is read once.
        grip: Of each foot, (F, N); None reads it from the forces.
    """
    pose = np.column_stack([signals.body_m[:, :2], signals.body_rad[:, 2]])
    joints, legs = command_rad.shape[1], signals.force_n.shape[1]
    out = np.empty(((grid.frames + 1) // 2, joints + 8 * legs + CHANNELS_OF_BODY))
    shaft, command, foot, force, body, angle, velocity = map(given_rows, (
        signals.shaft_rad, command_rad, signals.foot_m, signals.force_n, signals.body_m,
        signals.body_rad, body_velocity(grid, pose),
    ))  # fmt: skip
    pulls_n = max(float(CONTACT_N), PULL_SHARE * windows.least_n)
    _lay(shaft, command, foot, force, body, angle, velocity, pulls_n, out)
    dynamics = joints + 6 * legs + 3
    out[:, _mean_columns(legs)] = means_of(windows, given_rows(out[:, dynamics : dynamics + 3]))
    out[:, -legs:] = grip_of(windows, _forces(out, joints, legs)) if grip is None else grip
    return out


def _pull_columns(legs: int) -> slice:
    """Columns of what is far below 0 of the forces on feet."""
    return slice(-2 * legs - len(MEANS), -legs - len(MEANS))


def _mean_columns(legs: int) -> slice:
    """Columns of the body's mean velocity: behind them are the grips alone."""
    return slice(-legs - len(MEANS), -legs)


def _forces(values: FloatArray, joints: int, legs: int) -> FloatArray:
    """Forces on feet in channels, (F, N, 3)."""
    sideways = joints + 4 * legs + 3
    xy = values[:, sideways : sideways + 2 * legs].reshape(len(values), legs, 2)
    up = values[:, joints + 3 * legs : joints + 4 * legs, None]
    return np.concatenate([xy, up], axis=2)


@compiled
def _lay(
    shaft: FloatArray, command: FloatArray, foot: FloatArray, force: FloatArray, body: FloatArray,
    angle: FloatArray, velocity: FloatArray, pulls_n: float, out: FloatArray,
) -> None:  # fmt: skip
    """Every channel at every second frame, averaged with its neighbours (``model.effects.grid.DOWN``).

    A foot pulls where its force is below ``-pulls_n``: the zero of a load cell is another on each day.
    """
    frames, joints, legs = shaft.shape[0], shaft.shape[1], force.shape[1]
    support = joints + 3 * legs
    friction = support + legs + 3
    dynamics = friction + 2 * legs
    for row in range(out.shape[0]):
        f = 2 * row
        a, b = max(f - 1, 0), min(f + 1, frames - 1)
        for j in range(joints):
            out[row, j] = _averaged(
                shaft[a, j] - command[a, j],
                shaft[f, j] - command[f, j],
                shaft[b, j] - command[b, j],
            )
        for k in range(legs):
            for i in range(3):
                out[row, joints + 3 * k + i] = _averaged(
                    foot[a, k, i], foot[f, k, i], foot[b, k, i]
                )
            out[row, support + k] = _averaged(force[a, k, 2], force[f, k, 2], force[b, k, 2])
            for i in range(2):
                out[row, friction + 2 * k + i] = _averaged(
                    force[a, k, i], force[f, k, i], force[b, k, i]
                )
        out[row, support + legs] = _averaged(body[a, 2], body[f, 2], body[b, 2])
        for i in range(2):
            out[row, support + legs + 1 + i] = _averaged(angle[a, i], angle[f, i], angle[b, i])
        for i in range(3):
            out[row, dynamics + i] = _averaged(velocity[a, i], velocity[f, i], velocity[b, i])
            out[row, dynamics + 3 + i] = _averaged(
                _total(force[a], i), _total(force[f], i), _total(force[b], i)
            )
            out[row, dynamics + 6 + i] = _averaged(
                _moment(foot[a], force[a], i),
                _moment(foot[f], force[f], i),
                _moment(foot[b], force[b], i),
            )
        for k in range(legs):
            pulled = out[row, support + k] + pulls_n
            out[row, dynamics + 9 + k] = pulled
            if pulled >= 0.0:  # and NaN stays
                out[row, dynamics + 9 + k] = 0.0


@compiled
def _averaged(before: float, here: float, after: float) -> float:
    return SIDE * (before + after) + MIDDLE * here


@compiled
def _total(force: FloatArray, axis: int) -> float:
    """The total force along an axis; forces are (N, 3)."""
    total = 0.0
    for k in range(force.shape[0]):
        total += force[k, axis]
    return total


@compiled
def _moment(foot: FloatArray, force: FloatArray, axis: int) -> float:
    """Its moment about an axis through the body's origin; feet and forces are (N, 3)."""
    second, third = (axis + 1) % 3, (axis + 2) % 3
    total = 0.0
    for k in range(force.shape[0]):
        total += foot[k, second] * force[k, third] - foot[k, third] * force[k, second]
    return total


def cycles_of(inputs: LeggedInputs) -> FloatArray:
    """Return the cycles of a trial's gait, (W,); NaN if not known."""
    time_s, frequency_hz = inputs.grid.time_s, inputs.trial.header.frequency_hz
    return gait_cycle(time_s, inputs.command_rad, inputs.shaft_rad, frequency_hz)


def make_observation(
    inputs: LeggedInputs, load_n: FloatArray, windows: Windows, length_m: float
) -> Observation:
    """Put measured data on the channels, with their noise and weights.

    Args:
        inputs: Measured data on the working grid.
        load_n: Loads that the unchanged simulator predicts, (W, N); they tell contact switches.
        windows: In which the grip of each foot is read.
        length_m: From the middle of the machine to its farthest foot.
    """
    grid = inputs.grid
    joints, legs = inputs.command_rad.shape[1], inputs.force_n.shape[1]
    values = to_channels(grid, inputs.command_rad, inputs, windows)
    given = inputs.trial.header.noise
    noise = np.broadcast_to(_noise(grid, given, joints, legs, length_m, windows), values.shape)
    time_s = grid.time_s[::2]
    weight = _weight(grid, inputs.force_n[..., 2], load_n, values.shape)
    weight[:, _pull_columns(legs)] = (weight[:, :1] > 0.0) * PULL_WEIGHT
    weight[:, _mean_columns(legs)] *= weight_of_frames(windows, MEAN_READINGS)
    weight[:, -legs:] *= weight_of_frames(windows, GRIP_READINGS)
    return Observation(
        time_s=readonly(time_s.copy()),
        cycle=readonly(cycles_of(inputs)[::2].copy()),
        values=readonly(values),
        noise=readonly(noise.copy()),
        weight=readonly(weight),
        reach_m=_reach(inputs, length_m),
    )


def _reach(inputs: LeggedInputs, length_m: float) -> tuple[float, float]:
    x = inputs.body_m[np.isfinite(inputs.body_m[:, 0]), 0]
    if not len(x):
        return NOWHERE
    return (float(x.min()) - length_m, float(x.max()) + length_m)


def _noise(
    grid: Grid, given: TrialNoise, joints: int, legs: int, length_m: float, windows: Windows
) -> FloatArray:
    def sigma(name: str) -> float:
        value: float = getattr(given, name)
        return value if np.isfinite(value) and value > 0 else float(getattr(ASSUMED, name))

    mean = placed_noise(grid)
    # the slope's noise before samples are averaged to the grid, so a bound from above
    slope = grid.slope_noise(TWIST_WINDOW_S)
    fine = np.sqrt(max(grid.period_s / grid.source_period_s, 1.0))
    window_s = (grid.time_s[-1] - grid.time_s[0]) / windows.number
    return np.concatenate([
        np.full(joints, mean * sigma("shaft_rad")),
        np.full(3 * legs, mean * sigma("foot_position_m")),
        np.full(legs, mean * sigma("force_n")),
        [mean * sigma("body_position_m")],
        np.full(2, mean * sigma("body_angle_rad")),
        np.full(2 * legs, mean * sigma("force_n")),
        np.full(2, slope / fine * sigma("body_position_m")),
        [slope / fine * sigma("body_angle_rad")],
        np.full(3, np.sqrt(legs) * mean * sigma("force_n")),
        np.full(3, np.sqrt(legs) * mean * sigma("force_n") * 0.5 * length_m),
        np.full(legs, mean * sigma("force_n")),
        mean_noise(sigma("body_position_m"), sigma("body_angle_rad"), window_s),
        np.full(legs, GRIP_NOISE),
    ])  # fmt: skip


def _weight(
    grid: Grid, force_z: FloatArray, load_n: FloatArray, shape: tuple[int, ...]
) -> FloatArray:
    """Less where a foot touches down or lifts off, nothing at the ends, (F, C)."""
    frames = grid.frames
    legs = load_n.shape[1]
    before_loads = shape[1] - 5 * legs - CHANNELS_OF_BODY  # shafts and free feet
    near = np.zeros(frames, dtype=bool)
    reach = max(1, round(SWITCH_S / grid.period_s))
    for loads in (force_z, load_n):
        down_now = np.nan_to_num(loads) > CONTACT_N
        for at in np.flatnonzero((down_now[1:] != down_now[:-1]).any(axis=1)):
            near[max(0, at + 1 - reach) : at + 1 + reach] = True
    weight = np.ones(shape)
    switching = near[::2]
    # shafts, free feet and what lasts know nothing of it
    weight[switching, before_loads : _mean_columns(legs).start] = SWITCH_WEIGHT
    time_s = grid.time_s[::2]
    weight[(time_s < EDGE_S) | (time_s > grid.time_s[-1] - EDGE_S)] = 0.0
    return weight
