"""A lab's walk of a robot whose legs have several joints: MuJoCo moves it, a CSV says what was measured.

    python examples/chain_walk.py hexapod18 chain.csv    # or quadruped12
    bigant import chain.csv --map chain.map.toml --out chain.mcap
    bigant odom chain.mcap --compare

Feet follow a scripted gait by position servos on every joint; contacts, slip and tilt are MuJoCo's. The
CSV has what a lab would have: time, commanded and measured joint angles [deg], joint speeds [deg/s], the
body's pose [mm, deg] as motion capture gives it and, with --forces, those of the ground on the feet [N].
The map says so, the robot's files are copied beside it.
"""

import argparse
import csv
import math
from pathlib import Path

import mujoco
import numpy as np

from model.kinematics.chain import ChainKinematics
from model.parameters.chain_table import read_chain
from model.parameters.tables import parse_table
from model.values.arrays import FloatArray
from record.chain_file import complete

HERE = Path(__file__).parent
RATE_HZ = 100
SETTLE_S = 1.0
# Of each robot: phase of touchdown of each leg, stance share, period [s], step [m], lift [m], how far the
# body sways away from the legs in the air [m], and the joint angles of one leg in which it stands.
GAITS = {
    "hexapod18": ((0, 0.5, 0, 0.5, 0, 0.5), 0.6, 1.2, 0.06, 0.025, 0.0, (0.0, 0.0, 0.0)),
    "quadruped12": ((0.0, 0.5, 0.75, 0.25), 0.85, 4.0, 0.08, 0.03, 0.06, (0.0, 0.9, -1.8)),
}


def foot_targets(
    stand: FloatArray, name: str, cycles: float, turn_rad: float
) -> tuple[FloatArray, FloatArray]:
    """Return times, (T,) [s], and feet in the body frame, (T, N, 3) [m], that walk ahead and turn left."""
    touchdown, duty, period_s, step_m, lift_m, sway_m, _ = GAITS[name]
    time_s = np.arange(0, cycles * period_s, 1 / RATE_HZ)
    phase = (time_s[:, None] / period_s - np.array(touchdown)) % 1.0
    swing = np.clip((phase - duty) / (1 - duty), 0, 1)
    # from 1/2 to -1/2 of a step in stance, and back in a smooth swing
    back = np.where(phase < duty, 0.5 - phase / duty, -0.5 + 0.5 * (1 - np.cos(math.pi * swing)))
    feet = np.tile(stand, (len(time_s), 1, 1))
    by = turn_rad * back  # the body turns left: feet in stance go round it to the right
    c, s = np.cos(by), np.sin(by)
    feet[..., 0] = c * stand[:, 0] - s * stand[:, 1] + step_m * back
    feet[..., 1] = s * stand[:, 0] + c * stand[:, 1]
    feet[..., 1] -= sway_m * np.sin(2 * math.pi * (time_s[:, None] / period_s - 0.05))
    feet[..., 2] += lift_m * np.sin(math.pi * swing) ** 2
    ramp = np.clip(time_s / period_s, 0, 1)[:, None, None]  # the first cycle begins small
    return time_s, stand + ramp * (feet - stand)


def joint_angles(legs: ChainKinematics, feet: FloatArray, start: FloatArray) -> FloatArray:
    """Return the joint angles that put the feet there, (T, J): Newton steps with the exact Jacobian."""
    angles, angle = [], start
    for want in feet:
        for _ in range(20):
            off = want - legs.feet(angle, np.zeros_like(angle)).position_m
            if np.abs(off).max() < 1e-9:
                break
            slope = legs.jacobian(angle).reshape(-1, len(angle))
            angle = angle + np.linalg.lstsq(slope, off.ravel(), rcond=1e-9)[0]
        angles.append(angle)
    return np.array(angles)


def rolled(command: FloatArray, joints: tuple[str, ...], name: str) -> dict[str, FloatArray]:
    """Let MuJoCo walk: joint angles, their speeds, place and angles of the body at every row."""
    model = mujoco.MjModel.from_xml_path(str(HERE / f"{name}.xml"))
    data = mujoco.MjData(model)
    actuators = [model.actuator(joint).id for joint in joints]
    places = [model.joint(joint).qposadr[0] for joint in joints]
    speeds = [model.joint(joint).dofadr[0] for joint in joints]
    data.qpos[places] = command[0]
    mujoco.mj_kinematics(model, data)
    lowest = min(data.geom(geom).xpos[2] for geom in _feet(model))
    data.qpos[2] -= lowest - model.geom(_feet(model)[0]).size[0]
    steps = round(1 / (RATE_HZ * model.opt.timestep))
    data.ctrl[actuators] = command[0]
    mujoco.mj_step(model, data, nstep=round(SETTLE_S / model.opt.timestep))
    rows: dict[str, list[FloatArray]] = {"q": [], "qd": [], "place": [], "angles": [], "force": []}
    for row in command:
        rows["q"].append(data.qpos[places].copy())
        rows["qd"].append(data.qvel[speeds].copy())
        rows["place"].append(data.qpos[:3].copy())
        rows["angles"].append(_roll_pitch_yaw(data.qpos[3:7]))
        rows["force"].append(_foot_forces(model, data))
        data.ctrl[actuators] = row
        mujoco.mj_step(model, data, nstep=steps)
    return {key: np.array(values) for key, values in rows.items()}


def _feet(model: mujoco.MjModel) -> list[str]:
    names = [model.geom(geom).name for geom in range(model.ngeom)]
    return [name for name in names if name.endswith("_foot")]


def _foot_forces(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """Force of the ground on each foot in the order of the model, body axes, flat (3 N,)."""
    feet = [model.geom(name).id for name in _feet(model)]
    forces, one = np.zeros((len(feet), 3)), np.zeros(6)
    for at in range(data.ncon):
        contact = data.contact[at]
        mujoco.mj_contactForce(model, data, at, one)
        push = contact.frame.reshape(3, 3).T @ one[:3]  # on the second geom
        if contact.geom2 in feet:
            forces[feet.index(contact.geom2)] += push
        elif contact.geom1 in feet:
            forces[feet.index(contact.geom1)] -= push
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    return (forces @ turn.reshape(3, 3)).ravel()


def _roll_pitch_yaw(quaternion_wxyz: FloatArray) -> FloatArray:
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, quaternion_wxyz)
    m = turn.reshape(3, 3)
    return np.array(
        [math.atan2(m[2, 1], m[2, 2]), -math.asin(m[2, 0]), math.atan2(m[1, 0], m[0, 0])]
    )


def walk(
    name: str,
    out: Path,
    cycles: float,
    turn_deg: float,
    seed: int,
    fault: tuple[str, float] = ("", 0),
    *,
    forces: bool = False,
) -> None:
    """Write the CSV, the map to import it with, and the robot's files beside them.

    With a fault, a joint's encoder reads so much less than the truth [rad]: its servo, which goes by the
    encoder, puts the joint as much too far.
    """
    text = complete((HERE / f"{name}.toml").read_text(encoding="utf-8"), HERE)
    top = parse_table(text)
    order = top.table("legs").texts("order")
    chain = read_chain(top.table("leg").table("chain"), len(order))
    legs, stance = ChainKinematics(chain), np.tile(GAITS[name][-1], len(order))
    stand = legs.feet(stance, np.zeros_like(stance)).position_m
    time_s, feet = foot_targets(stand, name, cycles, math.radians(turn_deg))
    command = joint_angles(legs, feet, stance)
    unseen = np.array([fault[1] if joint == fault[0] else 0.0 for joint in chain.joints])
    went = rolled(command + unseen, chain.joints, name)
    noise = np.random.default_rng(seed)
    columns = {
        "t": time_s,
        **_each("cmd", chain.joints, np.degrees(command)),
        **_each(
            "q", chain.joints, np.degrees(went["q"] - unseen + noise.normal(0, 1e-3, command.shape))
        ),
        **_each("qd", chain.joints, np.degrees(went["qd"] + noise.normal(0, 1e-2, command.shape))),
        **_each(
            "body", ("x", "y", "z"), 1e3 * went["place"] + noise.normal(0, 0.5, (len(feet), 3))
        ),
        **_each("body", ("roll", "pitch", "yaw"), np.degrees(np.unwrap(went["angles"], axis=0))),
    }
    if forces:
        axes = tuple(f"{leg}_{axis}" for leg in order for axis in "xyz")
        noisy = went["force"] + noise.normal(0, 0.1, went["force"].shape)
        columns |= _each("F", axes, noisy)
    out.parent.mkdir(parents=True, exist_ok=True)
    with out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(np.round(np.column_stack(list(columns.values())), 6).tolist())
    out.with_suffix(".map.toml").write_text(
        map_text(name, chain.joints, order if forces else ()), encoding="utf-8"
    )
    for file in (f"{name}.toml", f"{name}.xml"):  # which may lie there already
        (out.parent / file).write_bytes((HERE / file).read_bytes())
    moved = went["place"][-1] - went["place"][0]
    print(f"{out}: {len(time_s)} rows, {len(chain.joints)} joints, {1e3 * moved[0]:.0f} mm ahead, "
          f"{np.degrees(went['angles'][-1, 2]):.0f} deg of yaw")  # fmt: skip


def _each(word: str, names: tuple[str, ...], values: FloatArray) -> dict[str, FloatArray]:
    return {f"{word}_{name}": column for name, column in zip(names, values.T, strict=True)}


def map_text(name: str, joints: tuple[str, ...], sensors: tuple[str, ...]) -> str:
    """Return which column is which of ours, for bigant import --map."""
    lines = ["[columns]", 'time_s = "t"']
    for joint in joints:
        lines += [
            f'command_{joint}_rad = {{ from = "cmd_{joint}", unit = "deg" }}',
            f'shaft_{joint}_rad = {{ from = "q_{joint}", unit = "deg" }}',
            f'shaft_{joint}_rad_s = {{ from = "qd_{joint}", unit = "deg/s" }}',
        ]
    lines += [f'body_{axis}_m = {{ from = "body_{axis}", unit = "mm" }}' for axis in "xyz"]
    for angle in ("roll", "pitch", "yaw"):
        lines.append(f'body_{angle}_rad = {{ from = "body_{angle}", unit = "deg" }}')
    lines += [f'force_{leg}_{axis}_n = "F_{leg}_{axis}"' for leg in sensors for axis in "xyz"]
    period_s = GAITS[name][2]
    lines += ["[trial]", f'robot = "{name}.toml"', 'gait = "other"',
              f"frequency_hz = {1 / period_s:g}", f"sample_rate_hz = {RATE_HZ}.0"]  # fmt: skip
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", choices=GAITS)
    parser.add_argument("out", type=Path, help="the CSV to write")
    parser.add_argument("--cycles", type=float, default=10.0)
    parser.add_argument("--turn-deg", type=float, default=0.0, help="to the left, a cycle")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fault", nargs=2, default=("", "0"), metavar=("JOINT", "RAD"),
                        help="a joint whose encoder reads so much less than the truth")  # fmt: skip
    parser.add_argument("--forces", action="store_true", help="of the ground on the feet, too")
    given = parser.parse_args()
    fault = (given.fault[0], float(given.fault[1]))
    walk(
        given.robot, given.out, given.cycles, given.turn_deg, given.seed, fault, forces=given.forces
    )
