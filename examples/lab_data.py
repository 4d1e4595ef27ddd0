"""A walk as a lab would bring it: a CSV file of its own columns and a ROS 2 bag, of a virtual robot.

python examples/lab_data.py FOLDER [GAIT] [CYCLES] [SEED]

Angles in degrees, times in milliseconds, motion capture in millimetres with y up and a marker of its own
clockwork, no speeds and no forces. examples/lab_csv.toml and examples/lab_bag.toml say which is which:

bigant import FOLDER/lab.csv --map FOLDER/lab_csv.toml --out FOLDER/csv.mcap
bigant odom FOLDER/csv.mcap --compare --out FOLDER/csv.html
"""

import shutil
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from record.log.recording import Recording
from robot.config.robot_file import load_robot
from robot.virtual.walk import walk_in_memory

MARKER_M = (0.06, -0.02, 0.11)  # where the marker sits on the body
# Their axes of ours: x is x, y points up, z is our -y.
TO_THEIRS = Rotation.from_euler("X", -90, degrees=True)
START_NS = 1_767_225_600_000_000_000


def write_csv(walk: Recording, path: Path) -> None:
    """Write what a logger and a motion capture system write down."""
    body = Rotation.from_quat(walk.truth_quaternion_xyzw)
    marker = TO_THEIRS.apply(walk.truth_position_W + body.apply(MARKER_M))
    qx, qy, qz, qw = (TO_THEIRS * body * TO_THEIRS.inv()).as_quat().T
    columns = {"Time (ms)": 1e3 * walk.t_s}
    for k, leg in enumerate(walk.names):
        columns[f"{leg} goal"] = np.degrees(walk.sent_angle_rad[:, k])
        columns[f"{leg} angle"] = np.degrees(walk.angle_rad[:, k])
    columns |= dict(zip(("X", "Y", "Z"), 1e3 * marker.T, strict=True))
    columns |= {"QW": qw, "QX": qx, "QY": qy, "QZ": qz}
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, "%.6f", ",", header=",".join(columns), comments="")


def write_bag(walk: Recording, path: Path) -> None:
    """Write joint states, commands and poses as a ROS 2 bag, poses at half the rate."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    stamp = kinds["builtin_interfaces/msg/Time"]
    head = kinds["std_msgs/msg/Header"]
    state = kinds["sensor_msgs/msg/JointState"]
    pose = kinds["geometry_msgs/msg/PoseStamped"]
    inner = kinds["geometry_msgs/msg/Pose"]
    point, quaternion = (kinds[f"geometry_msgs/msg/{k}"] for k in ("Point", "Quaternion"))
    names = [f"{leg.lower()}_shaft" for leg in walk.names]
    nothing = np.zeros(0)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        joints, goals, poses = (
            writer.add_connection(topic, kind.__msgtype__, typestore=store)
            for topic, kind in (
                ("/joint_states", state), ("/joint_commands", state), ("/mocap/robot/pose", pose)
            )
        )  # fmt: skip
        for k, t_s in enumerate(walk.t_s):
            ns = START_NS + round(1e9 * t_s)
            header = head(stamp(ns // 10**9, ns % 10**9), "map")
            for where, angles in ((joints, walk.angle_rad[k]), (goals, walk.sent_angle_rad[k])):
                message = state(header, names, angles, nothing, nothing)
                writer.write(where, ns, store.serialize_cdr(message, state.__msgtype__))
            if k % 2 == 0:
                place = point(*walk.truth_position_W[k].tolist())
                turn = quaternion(*walk.truth_quaternion_xyzw[k].tolist())
                message = pose(header, inner(place, turn))
                writer.write(poses, ns, store.serialize_cdr(message, pose.__msgtype__))


def main(folder: Path, gait: str = "tripod", cycles: float = 3.0, seed: int = 1) -> None:
    """Walk, and write both with their maps into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    config = load_robot()
    walk = walk_in_memory(config, gait, cycles=cycles, seed=seed, progress=lambda _: None)
    (folder / "bigant.toml").write_text(config.text, encoding="utf-8")
    for name in ("lab_csv.toml", "lab_bag.toml"):  # which may lie there already
        (folder / name).write_bytes(Path(__file__).with_name(name).read_bytes())
    write_csv(walk, folder / "lab.csv")
    shutil.rmtree(folder / "bag", ignore_errors=True)
    write_bag(walk, folder / "bag")


if __name__ == "__main__":
    words = sys.argv[1:]
    main(
        Path(words[0] if words else "lab"),
        *words[1:2],
        *map(float, words[2:3]),
        *map(int, words[3:4]),
    )
