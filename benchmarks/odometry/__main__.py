"""The estimator's bars: virtual walks of plants it does not know, Monte Carlo of its own model, soundness.

``python -m benchmarks.odometry walks FOLDER [SEED...]`` judges walks made by ``benchmarks.odometry.walks``;
``montecarlo`` draws worlds from the filter's own model; ``steps`` runs a million of them; ``ukf FOLDER``
runs an unscented filter beside it.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from benchmarks.odometry.walks import GAITS, JUDGED_SEEDS, log_of, plant_of
from model.estimator import process
from model.estimator.filter import Estimator
from model.estimator.neighbourhood import Neighbourhood, neighbourhood
from model.estimator.settings import EstimatorSettings, record_of
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray, known_mean, root_mean_square
from model.values.estimate import BIAS, FIXED, SCALE, VELOCITY, OdometryInputs
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import ContactParameters
from record.log.blocks.read import read_log
from record.log.reader import read_stamped_ticks
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.odometry.compare import compare_methods, true_motion, walking_part
from robot.odometry.metrics import in_band, nees
from robot.odometry.track import TrackedLog, track, track_log
from robot.report.walk_frames import fit_contact, walk_frames
from robot.requests.recorded import OdomRequest
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, simulate, slip_of_feet

SLIPPING_CYCLES = 4


@dataclass(frozen=True, slots=True)
class Row:
    """Figures of one walk, in the order of ``TITLES``."""

    values: tuple[float, ...]


TITLES = (
    "vx, % of naive", "vy, % of naive", "yaw rate, % of naive", "vx RMSE, mm/s", "naive vx, mm/s",
    "RPE 0.5 m, %", "naive RPE 0.5 m, %", "end, % of path", "naive end, %",
    "force RMSE / offline fit, Fx", "the same, Fy", "the same, Fz",
    "NEES velocity", "NEES pose", "NIS over numbers", "mu correlation after 4 cycles",
    "K correlation", "step median, us", "step 99 %, us",
)  # fmt: skip


def judge(gait: str, seed: int, folder: Path) -> Row:
    """One walk: the estimator believes the robot file, the plant has its own legs."""
    tracked = track_log(log_of(folder, gait, seed), OdomRequest(robot=DEFAULT_ROBOT_FILE))
    log, found = tracked.log, compare_methods(tracked)
    run, (mine, naive) = found.track, found.errors[:2]
    phase = log.gait_phase[walking_part(log)]
    after = run.estimates[int(np.searchsorted(phase, phase[0] + SLIPPING_CYCLES))]
    stiffness, mu = plant_of(seed)
    ratio = 100 * mine.velocity_rmse / naive.velocity_rmse
    forces = _force_ratio(tracked, run.force_B)
    return Row((
        *ratio.tolist(), 1e3 * mine.velocity_rmse[0], 1e3 * naive.velocity_rmse[0],
        mine.rpe_percent[1], naive.rpe_percent[1], mine.end_percent, naive.end_percent,
        *forces,
        *map(known_mean, (found.twist_nees, found.pose_nees, run.nis_over_dof)),
        float(np.corrcoef(after.mu, mu)[0, 1]),
        float(np.corrcoef(after.stiffness, stiffness)[0, 1]),
        *np.percentile(run.step_us, [50, 99]).tolist(),
    ))  # fmt: skip


def _force_ratio(tracked: TrackedLog, predicted: FloatArray) -> list[float]:
    """Force RMSE on the later half over that of Coulomb parameters fitted offline to the earlier one.

    The offline fit knows the true slip and forces of its half; both predict with Coulomb's law.
    """
    log, robot = tracked.log, tracked.config.parameters
    span = walking_part(log)
    middle = (span.start + span.stop) // 2
    walk = walk_frames(log, "walk")
    earlier = type(walk)(*(getattr(walk, f)[: middle - span.start] for f in walk.__slots__))
    fitted = fit_contact(earlier, log.names, free_w=False, rest_m_s=1e-3, law=FrictionLaw.COULOMB)
    late = slice(middle, span.stop)
    kinematics = leg_kinematics(robot)
    feet = kinematics.feet(log.angle_rad[late], log.rate_rad_s[late])
    solved = solve_frames(
        feet, fitted.contact, robot.body.mass * STANDARD_GRAVITY, law=FrictionLaw.COULOMB
    )
    offline = np.concatenate([solved.force_xy_B, solved.load_n[..., None]], axis=2)
    true = log.truth_force_n[late]

    def over_legs(force: FloatArray) -> FloatArray:
        size: FloatArray = np.sqrt((root_mean_square(force - true) ** 2).mean(axis=0))
        return size

    share = over_legs(predicted[middle - span.start :]) / over_legs(offline)
    return [float(value) for value in share]


def walks(folder: Path, seeds: tuple[int, ...], gaits: tuple[str, ...]) -> None:
    for gait in gaits:
        there = [s for s in seeds if log_of(folder, gait, s).exists()]
        rows = np.array([judge(gait, seed, folder).values for seed in there])
        print(f"{gait}, {len(there)} walks, seeds {there}: median (least, most)", flush=True)
        for title, column in zip(TITLES, rows.T, strict=True):
            print(
                f"  {title:<32}{np.median(column):>9.3g}  ({column.min():.3g}, {column.max():.3g})"
            )


def montecarlo(runs: int = 50, ticks: int = 300) -> None:
    """Worlds of the filter's own: tier one of consistency."""
    for parameter_sd in (0.25, 0.1, 0.03):
        settings = replace(
            EstimatorSettings(),
            parameter_sd=parameter_sd,
            scale_sd=min(parameter_sd, 0.25),
            vibration_s=0.0,
            vibration_per_slip=0.0,  # forces are drawn: they shake nothing
        )
        total = np.zeros((2, ticks))
        nis = []
        for seed in range(runs):
            world = simulate(settings, 5000 + seed, ticks)
            estimator = Estimator(CONTACT, WEIGHT_N, settings)
            state, said = estimator.initial(), []
            for known in world.inputs:
                state, estimate = estimator.step(state, known)
                said.append(estimate)
            velocity = np.array([e.velocity_B for e in said])
            pose = np.array([[*e.position_m, e.yaw_rad] for e in said])
            twist_covariance = np.array([e.twist_covariance for e in said])
            pose_covariance = np.array([e.pose_covariance for e in said])
            total[0] += nees(velocity - world.velocity, twist_covariance) / runs
            total[1] += nees(pose - world.pose, pose_covariance) / runs
            share = [e.nis / max(e.nis_dof, 1) for e in said]
            nis.append(float(np.nanmean(share)))
        print(
            f"parameters known to {parameter_sd}: {runs} worlds, {ticks} ticks; NEES velocity "
            f"{total[0].mean():.2f}, {100 * in_band(total[0], 3, runs):.0f} % in band (after 1 s "
            f"{100 * in_band(total[0, 100:], 3, runs):.0f} %); pose {total[1].mean():.2f}, "
            f"{100 * in_band(total[1], 3, runs):.0f} %; NIS {np.mean(nis):.2f}",
            flush=True,
        )


def steps(count: int = 1_000_000) -> None:
    """Covariance symmetric and positive definite all the way."""
    world = simulate(EstimatorSettings(), 77, 1000)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    smallest, mended = np.inf, 0
    for i in range(count):
        known = world.inputs[i % 1000]
        forces = known.forces if (i // 1000) % 3 else None
        if forces is not None:
            forces = replace(forces, t_ns=i * PERIOD_NS)
        state, said = estimator.step(state, replace(known, t_ns=i * PERIOD_NS, forces=forces))
        mended += "mended" in said.reason
        if not np.array_equal(state.covariance, state.covariance.T):
            raise SystemExit(f"not symmetric at step {i}")
        if i % 100 == 0:
            smallest = min(smallest, float(np.linalg.eigvalsh(state.covariance)[0]))
        if (i + 1) % 100_000 == 0:
            print(f"{i + 1} steps: smallest eigenvalue {smallest:.3g}, mended {mended}", flush=True)


def ukf(folder: Path, seed: int = 901, ticks: int = 600) -> None:
    """filterpy's unscented filter on the same model and noise, offline, beside the EKF."""
    config = load_robot()
    robot, weight_n = config.parameters, config.parameters.body.mass * STANDARD_GRAVITY
    kinematics = leg_kinematics(robot)
    for gait in GAITS:
        path = log_of(folder, gait, seed)
        first = walking_part(read_log(path)).start
        walked = list(read_stamped_ticks(path))[first : first + ticks]
        truth = true_motion(read_log(path), slice(first, first + ticks))
        assert truth is not None
        inputs = []
        for tick in (item.tick for item in walked):
            feet = kinematics.feet(tick.joints.angle_rad, tick.joints.rate_rad_s)
            inputs.append(OdometryInputs(tick.t_ns, feet, tick.forces))
        ekf = track(walked, config).velocity_B
        unscented = _unscented(inputs, robot.contact, weight_n, np.zeros(3))
        for name, velocity in (("EKF", ekf), ("UKF", unscented)):
            error = 1e3 * root_mean_square(velocity - truth.velocity_B)
            print(f"{gait} {name}: RMSE {error[0]:.3f} {error[1]:.3f} mm/s, {error[2]:.3f} mrad/s")
        print(f"  apart: {1e3 * root_mean_square(unscented - ekf)}", flush=True)


def _unscented(
    inputs: list[OdometryInputs], contact: ContactParameters, weight_n: float, pose: FloatArray
) -> FloatArray:
    settings = EstimatorSettings()
    estimator = Estimator(contact, weight_n, settings)
    state = estimator.initial(pose)
    size, legs = len(state.mean), len(contact.mu)
    points = MerweScaledSigmaPoints(size, alpha=0.5, beta=2.0, kappa=0.0)
    filter_ = UnscentedKalmanFilter(size, 1, 0.01, hx=None, fx=None, points=points)
    filter_.x, filter_.P = state.mean.copy(), state.covariance.copy()
    fixed = record_of(replace(settings, parameter_walk=0.0), weight_n)

    def solved(x: FloatArray, known: OdometryInputs) -> Neighbourhood:
        answer = neighbourhood(x, known.feet, contact, fixed)
        assert answer is not None
        return answer

    out = [state.mean[VELOCITY].copy()]
    for i in range(1, len(inputs)):
        known = inputs[i]
        # the EKF says which feet are used and with what noise; the UKF does the rest its own way
        state, said = estimator.step(state, known)
        model = solved(filter_.x, known)
        step = process.walking(filter_.x, filter_.P, model, fixed, 0.01)
        filter_.Q = symmetric_floor(step.noise)
        filter_.predict(
            fx=lambda x, _dt, known=known: (
                process.walking(x, filter_.P, solved(x, known), fixed, 0.01).mean
            )
        )
        which = np.isfinite(said.innovation[:, 0])
        loads = np.isfinite(said.innovation[:, 2])
        if said.nis_dof and known.forces is not None:
            share = known.forces.force_n / known.forces.force_n[:, 2].sum()
            filter_.sigmas_f = points.sigma_points(filter_.x, symmetric_floor(filter_.P))

            def heard(x: FloatArray, known: OdometryInputs = known, share: FloatArray = share,
                      which: FloatArray = which, loads: FloatArray = loads) -> FloatArray:  # fmt: skip
                near = solved(x, known)
                slip = slip_of_feet(x[VELOCITY], known.feet, near.sway_B)
                length = np.sqrt((slip**2).sum(axis=1) + settings.creep_speed**2)
                mu = contact.mu * np.exp(x[SCALE] + x[FIXED : FIXED + legs])
                pull = -(mu * share[:, 2] / length)[:, None] * slip
                gauge = x[FIXED : FIXED + legs].sum(keepdims=True)
                return np.concatenate([near.load_n[loads] / weight_n, pull[which].ravel(), gauge])

            z = np.concatenate([share[loads, 2], share[which, :2].ravel(), [0.0]])
            level = (share[which, :2] ** 2).sum(axis=1)
            pair = settings.force_sd**2 + settings.force_share_sd**2 * level
            noise = np.concatenate([
                np.full(int(loads.sum()), settings.load_sd**2), np.repeat(pair, 2),
                [settings.gauge_sd**2],
            ])  # fmt: skip
            filter_.update(z, R=np.diag(noise), hx=heard)
        filter_.P = symmetric_floor(filter_.P)
        out.append(filter_.x[VELOCITY].copy())
    assert BIAS.stop == SCALE
    return np.array(out)


def symmetric_floor(matrix: FloatArray) -> FloatArray:
    """Symmetric, with a little on the diagonal: sigma points need a Cholesky root."""
    floor: FloatArray = 0.5 * (matrix + matrix.T) + 1e-14 * np.eye(len(matrix))
    return floor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("walks", "montecarlo", "steps", "ukf"))
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("seeds", type=int, nargs="*")
    parser.add_argument("--gait", choices=GAITS, action="append")
    options = parser.parse_args()
    if options.what in {"walks", "ukf"} and options.folder is None:
        parser.error("name the folder that benchmarks.odometry.walks made")
    if options.what == "walks":
        walks(options.folder, tuple(options.seeds) or JUDGED_SEEDS, tuple(options.gait or GAITS))
    elif options.what == "montecarlo":
        montecarlo()
    elif options.what == "steps":
        steps()
    else:
        ukf(options.folder)


if __name__ == "__main__":
    main()
