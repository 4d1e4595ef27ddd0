"""The diagnosis on logs of real machines that others measured; see docs/real/README.md.

Run it with ``BIGANT_SHARED_DATA=FOLDER python -m benchmarks.real_machines``. It turns each set into trials
(the maps are the functions below, and nothing is cut by hand), diagnoses them and prints what was found.
"""

import csv
import math
import os
import sys
import tempfile
from datetime import datetime
from pathlib import Path

import numpy as np

from gap.diagnosis import diagnose
from gap.findings import Diagnosis
from gap.interfaces import Simulator
from gap.servo_bench import servo_bench
from gap.sliding_body import sliding_body
from model.signals import FloatArray
from record.table_file import Column
from record.trial import Trial, build_trial
from record.trial_toml import SERVO_BENCH, SLIDING_BODY, TrialHeader, TrialNoise
from robot.gap_page import diagnosis_page
from robot.gap_summary import summary_lines

ARM = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll")
COUNT_RAD = 2 * math.pi / 4096
TAUT_COUNTS, PULL_NM = 300, 0.1
CUBE_HALF_M, FLAT_M, STILL_RAD_S, LEAST_M_S = 0.0524, 0.003, 1.5, 0.05
CUBE_STEP_S, FEWEST = 1 / 148, 24


def arm_trials(folder: Path, joint: str) -> list[Trial]:
    """One joint of the arm, one trial a motion."""
    robot = f'kind = "servo_bench"\n[joint.{joint}]\n'
    noise = TrialNoise(shaft_rad=COUNT_RAD)
    header = TrialHeader(
        SERVO_BENCH, (joint,), "other", math.nan, 50.0, "", noise, "arm.toml", robot
    )
    names = {"cmd": f"command_{joint}_rad", "pos": f"shaft_{joint}_rad",
             "vel": f"shaft_{joint}_rad_s", "tau": f"torque_{joint}_nm"}  # fmt: skip
    trials = []
    for path in sorted((folder / "so101_servo_arm").glob("*.npz")):
        data = np.load(path)
        columns = [Column("time_s", data["t"].astype(float))]
        at = ARM.index(joint)
        columns += [
            Column(ours, data[theirs][:, at].astype(float)) for theirs, ours in names.items()
        ]
        trials.append(build_trial(header, tuple(columns)))
    return trials


def rig_trial(folder: Path) -> Trial:
    """The held servo 5, pulled one way by servo 3 and the other way by servo 4.

    The pull is not measured. Its sign is that of the puller which is near the end of its travel; its size
    is set to one that is surely more than friction.
    """
    path = folder / "uart_servo_backlash" / "logs" / "motor_telemetry_single.csv"
    with path.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pos (5)"]]

    def column(name: str) -> FloatArray:
        return np.array([float(row[name]) for row in rows])

    stamps = [datetime.fromisoformat(row["timestamp"]) for row in rows]
    pull = np.zeros(len(rows))
    for servo, rest in (("3", 1748.0), ("4", 2347.0)):
        away = column(f"pos ({servo})") - rest
        pull -= np.where(np.abs(away) > TAUT_COUNTS, np.sign(away) * PULL_NM, 0.0)
    robot = 'kind = "servo_bench"\n[joint.servo]\nfriction = { coulomb_nm = 0.01, viscous_nm_s = 0.0 }\n'
    noise = TrialNoise(shaft_rad=COUNT_RAD)
    header = TrialHeader(
        SERVO_BENCH, ("servo",), "other", math.nan, 10.0, "", noise, "rig.toml", robot
    )
    return build_trial(header, (
        Column("time_s", np.array([(s - stamps[0]).total_seconds() for s in stamps])),
        Column("command_servo_rad", column("target pos (5)") * COUNT_RAD),
        Column("shaft_servo_rad", column("pos (5)") * COUNT_RAD),
        Column("torque_servo_nm", pull),
    ))  # fmt: skip


def cube_trials(folder: Path) -> list[Trial]:
    """Each toss from where the cube lies flat and no longer tumbles until it stops."""
    robot = 'kind = "sliding_body"\n[body]\nmass = 0.37\n[contact]\nlaw = "viscous"\nmu = 0.2\n'
    noise = TrialNoise(body_position_m=0.0002)
    tosses = np.load(folder / "sliding_cube" / "tosses.npz")
    trials = []
    for name in tosses.files:
        toss = tosses[name].astype(float)
        flat = np.abs(toss[:, 6] - np.median(toss[-5:, 6])) < FLAT_M
        calm = flat & (np.linalg.norm(toss[:, 7:10], axis=1) < STILL_RAD_S)
        fast = np.linalg.norm(toss[:, 10:12], axis=1) > LEAST_M_S
        first = len(calm) - int(np.argmax(~calm[::-1])) if not calm.all() else 0
        rows = np.flatnonzero(fast[first:])
        if len(rows) < FEWEST:
            continue
        part = toss[first : first + rows[-1] + 1]
        header = TrialHeader(
            SLIDING_BODY, (), "toss", math.nan, 148.0, "", noise, "cube.toml", robot
        )
        columns = [Column("time_s", np.arange(len(part)) * CUBE_STEP_S)]
        columns += [Column(f"body_{axis}_m", part[:, 4 + i]) for i, axis in enumerate("xy")]
        trials.append(build_trial(header, tuple(columns)))
    return trials


def _report(name: str, trials: list[Trial], simulator: Simulator, out: Path) -> Diagnosis:
    found = diagnose(trials, simulator)
    paths = [Path(f"{name}-{number}.csv") for number in range(len(trials))]
    print(f"== {name}: {len(trials)} trials, {len(found.held_out_trials)} kept back")
    print("\n".join(summary_lines(found, paths)[:40]))
    for c in found.far.channels:
        cut = f"{c.before:.4g} -> {c.after:.4g} {c.unit}, cut {1 - c.after / c.before:.0%}"
        print(f"RMS kept back {c.channel}: {cut}")
    (out / f"{name}.html").write_text(diagnosis_page(found, paths), encoding="utf-8")
    return found


def main() -> None:
    """Diagnose all three sets."""
    place = os.environ.get("BIGANT_SHARED_DATA", "")
    if not place:
        sys.exit("set BIGANT_SHARED_DATA to the folder of the data sets")
    folder = Path(place)
    out = Path(tempfile.mkdtemp(prefix="real-"))
    for joint in ARM:
        trials = arm_trials(folder, joint)
        _report(f"arm-{joint}", trials, servo_bench(trials), out)
    rig = [rig_trial(folder)]
    found = _report("rig", rig, servo_bench(rig), out)
    for cause in found.causes:
        for value in cause.values:
            if value.unit == "rad":
                print(
                    f"{cause.effect}: {value.value / COUNT_RAD:.2f} +- {value.error / COUNT_RAD:.2f} counts"
                )
    cube = cube_trials(folder)
    _report("cube", cube, sliding_body(cube), out)
    print(f"pages in {out}")


if __name__ == "__main__":
    main()
