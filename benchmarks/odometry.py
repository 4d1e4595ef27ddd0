"""The estimator's bars: virtual walks of plants it does not know, Monte Carlo of its own model, soundness.

``python -m benchmarks.odometry walks FOLDER [SEED...]`` judges walks made by ``benchmarks.odometry_walks``;
``montecarlo`` draws worlds from the filter's own model; ``steps`` runs a million of them; ``ukf FOLDER``
runs an unscented filter beside it.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from benchmarks.odometry_walks import GAITS, JUDGED_SEEDS, _load, plant_of
from model.estimator import process
from model.estimator.filter import Estimator
from model.estimator.neighbourhood import Neighbourhood, law_of, neighbourhood
from model.estimator.settings import EstimatorSettings, numbers_of
from model.estimator.step_kernel import WalkNoise
from model.parameters.robot import ContactParameters
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.estimate import BIAS, FIXED, SCALE, VELOCITY, OdometryInputs
from model.values.legs import FootMotion
from record.log.recording import Recording
from robot.config.robot_file import load_robot
from robot.odometry.compare import compare_ways, true_motion, walking_part
from robot.odometry.metrics import in_band, nees, rmse
from robot.odometry.track import feet_of, inputs_of, track, weight_of
from robot.study.sensitivity_frames import walk_frames
from robot.study.sensitivity_table import fit_contact
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
    "K correlation", "step median, us", "step 99 %, us", "cpu median, us", "cpu 99 %, us",
)  # fmt: skip


def judge(gait: str, seed: int, folder: Path) -> Row:
    """One walk: the estimator believes the robot file, the plant has its own legs."""
    log = _load(folder / f"{gait}_{seed}_9.npz")
    config = load_robot()
    found = compare_ways(log, config, EstimatorSettings())
    run, (mine, naive) = found.track, found.errors[:2]
    first, last = walking_part(log)
    phase = log.gait_phase[first:last]
    after = int(np.searchsorted(phase, phase[0] + SLIPPING_CYCLES))
    stiffness, mu = plant_of(seed)
    ratio = 100 * mine.velocity_rmse / naive.velocity_rmse
    forces = _force_ratio(log, run.force_B)
    used = run.nis_dof > 0
    return Row((
        *ratio.tolist(), 1e3 * mine.velocity_rmse[0], 1e3 * naive.velocity_rmse[0],
        mine.rpe_percent[1], naive.rpe_percent[1], mine.end_percent, naive.end_percent,
        *forces, float(found.twist_nees.mean()), float(found.pose_nees.mean()),
        float((run.nis[used] / run.nis_dof[used]).mean()),
        float(np.corrcoef(run.mu[after], mu)[0, 1]),
        float(np.corrcoef(run.stiffness[after], stiffness)[0, 1]),
        *np.percentile(run.step_us, [50, 99]).tolist(),
        *np.percentile(run.cpu_us, [50, 99]).tolist(),
    ))  # fmt: skip


def _force_ratio(log: Recording, predicted: FloatArray) -> list[float]:
    """Force RMSE on the later half over that of Coulomb parameters fitted offline to the earlier one.

    The offline fit knows the true slip and forces of its half; both predict with Coulomb's law.
    """
    first, last = walking_part(log)
    middle = (first + last) // 2
    config = load_robot()
    walk = walk_frames(log, "walk")
    earlier = type(walk)(*(getattr(walk, f)[: middle - first] for f in walk.__slots__))
    fitted = fit_contact(earlier, log.names, free_w=False, rest_m_s=1e-3, law=FrictionLaw.COULOMB)
    feet = feet_of(log, config)
    late = FootMotion(feet.position_m[middle:last], feet.velocity_m_s[middle:last])
    solved = solve_frames(late, fitted.contact, weight_of(config), law=FrictionLaw.COULOMB)
    offline = np.concatenate([solved.force_xy_B, solved.load_n[..., None]], axis=2)
    true = log.truth_force_n[middle:last]

    def over_legs(force: FloatArray) -> FloatArray:
        size: FloatArray = np.sqrt((rmse(force - true) ** 2).mean(axis=0))
        return size

    share = over_legs(predicted[middle - first :]) / over_legs(offline)
    return [float(value) for value in share]


def walks(folder: Path, seeds: tuple[int, ...], gaits: tuple[str, ...]) -> None:
    for gait in gaits:
        there = [s for s in seeds if (folder / f"{gait}_{s}_9.npz").exists()]
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
            EstimatorSettings(), parameter_sd=parameter_sd, scale_sd=min(parameter_sd, 0.25)
        )
        total = np.zeros((2, ticks))
        nis = []
        for seed in range(runs):
            world = simulate(settings, 5000 + seed, ticks)
            run = track(list(world.inputs), CONTACT, WEIGHT_N, settings)
            total[0] += nees(run.velocity_B - world.velocity, run.twist_covariance) / runs
            total[1] += nees(run.pose - world.pose, run.pose_covariance) / runs
            nis.append(float(np.nanmean(run.nis / np.maximum(run.nis_dof, 1))))
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
    contact, weight_n = config.parameters.contact, weight_of(config)
    for gait in GAITS:
        log = _load(folder / f"{gait}_{seed}_9.npz")
        first, _ = walking_part(log)
        inputs = inputs_of(log, feet_of(log, config), first, first + ticks)
        truth = true_motion(log, slice(first, first + ticks))
        assert truth is not None
        ekf = track(inputs, contact, weight_n, pose=truth[0][0])
        unscented = _unscented(inputs, contact, weight_n, truth[0][0])
        for name, velocity in (("EKF", ekf.velocity_B), ("UKF", unscented)):
            error = 1e3 * rmse(velocity - truth[1])
            print(f"{gait} {name}: RMSE {error[0]:.3f} {error[1]:.3f} mm/s, {error[2]:.3f} mrad/s")
        print(f"  apart: {1e3 * rmse(unscented - ekf.velocity_B)}", flush=True)


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
    law = law_of(settings)
    fixed = numbers_of(WalkNoise, replace(settings, parameter_walk=0.0), weight_n)

    def solved(x: FloatArray, known: OdometryInputs) -> Neighbourhood:
        answer = neighbourhood(x, known.feet, contact, weight_n, law)
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
        parser.error("name the folder that benchmarks.odometry_walks made")
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
