"""In-situ calibration end to end: virtual robot, log, sensors with known faults, command, file, forces."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.calibration import Calibration
from drivers.ati.foot_forces import ForceScales
from model.errors import RecordError
from model.values.arrays import FloatArray
from model.values.force_calibration import ForceCalibration, fourier_rows
from model.values.readings import ForceRecord
from model.values.tick import Intent, Tick
from record.log.reader import LogContents, read_ticks
from record.log.writer import NAMES_KEY, START_KEY, START_UNIX_KEY, LogWriter
from robot.bringup.force.still_poses import find_still_poses, joined, read_pose_logs
from robot.cli import main as cli
from robot.config.calibration import read_calibration
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.run.header import CALIBRATIONS_KEY, UNITS_KEY
from robot.run.rebuilt import calibrations_of
from robot.virtual.walk import record_poses
from tests.model.standing import true_faults
from tests.robot.runs import STOP, Told, drive, wish
from tests.soaked import THOROUGH, soaked

CONFIG = load_robot()
LEGS = CONFIG.parameters.legs.names


# What the calibration leaves of the faults at most, after so many rounds of poses.
LEFT = {1: 0.4, 2: 0.3}


@pytest.fixture(scope="module", params=soaked(LEFT, lambda rounds: rounds == 1, mark=THOROUGH))
def rounds(request: pytest.FixtureRequest) -> int:
    number: int = request.param
    return number


@pytest.fixture(scope="module")
def poses(rounds: int, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("poses") / "poses.mcap"
    record_poses(CONFIG, path, rounds=rounds, heights=4, seed=0, progress=lambda share: None)
    return path


def distorted(tick: Tick, faults: ForceCalibration) -> Tick:
    """The same tick as sensors with these faults would have seen it: counts changed, nothing else."""
    cross_talk = np.linalg.inv(np.eye(6) + faults.correction)
    rows = fourier_rows(tick.joints.angle_rad, faults.harmonics)
    unloaded = np.einsum("nh,nah->na", rows, faults.unloaded)

    def spoil(record: ForceRecord) -> ForceRecord:
        read = np.einsum("nij,nj->ni", cross_talk, record.counts * 1e-6) + unloaded
        return replace(record, counts=np.rint(read * 1e6).astype(np.int64))

    forces = tuple(spoil(record) for record in tick.inputs.forces)
    return replace(tick, inputs=replace(tick.inputs, forces=forces))


def write_distorted(source: Path, target: Path, faults: ForceCalibration) -> None:
    contents = LogContents()
    ticks = list(read_ticks(source, contents))
    own = {NAMES_KEY, START_KEY, START_UNIX_KEY}
    writer = LogWriter(
        target,
        names=LEGS,
        config_text=contents.config_text,
        metadata={k: v for k, v in contents.metadata.items() if k not in own},
        start_ns=int(contents.metadata[START_KEY]),
        start_unix_ns=int(contents.metadata[START_UNIX_KEY]),
    )
    for tick in ticks:
        writer.write(distorted(tick, faults))
    writer.close()
    assert writer.error is None


def force_error(
    ticks: Sequence[Tick], units: tuple[Calibration | None, ...], found: ForceCalibration
) -> float:
    """RMS of measured less true force over feet and components, in all ticks at rest [N]."""
    settings = replace(CONFIG.force_sensor, calibration=found)
    errors: list[FloatArray] = []
    for tick in ticks[::5]:
        truth = tick.inputs.truth
        still = np.abs(tick.joints.rate_rad_s).max() < 0.01
        if truth is not None and tick.inputs.forces and still:
            record = tick.inputs.forces[-1]
            forces = ForceScales(units, settings).forces(record, tick.joints.angle_rad)
            errors.append(forces.force_n - truth.foot_force_B)
    assert len(errors) > 100
    return float(np.sqrt((np.array(errors) ** 2).mean()))


@pytest.mark.soak
def test_known_faults_of_the_sensors_are_found_and_taken_out(
    poses: Path, rounds: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    faults = true_faults(np.random.default_rng(5))
    spoiled = tmp_path / "spoiled.mcap"
    write_distorted(poses, spoiled, faults)
    out, picture = tmp_path / "c.toml", tmp_path / "r.png"
    words = [
        "force",
        "calibrate",
        str(spoiled),
        "--out",
        str(out),
        "--report",
        str(picture),
        "--json",
    ]
    assert cli.run(words) == ExitCode.OK
    report = json.loads(capsys.readouterr().out)
    for leg in LEGS:
        before, after = (report["residuals"][stage][leg] for stage in ("before", "after"))
        assert before["standing_n"] > 1.5
        left = LEFT[rounds]
        assert after["standing_n"] < left * before["standing_n"], "gravity is not seen yet"
        assert after["standing_nm"] < left * before["standing_nm"]
        assert after["air_n"] is None or after["air_n"] < 0.2
    assert picture.stat().st_size > 10_000
    assert any("extrapolated" in text for text in report["warnings"])
    found = read_calibration(out, LEGS)
    assert found.logs == ("spoiled.mcap",)
    contents = LogContents()
    ticks = list(read_ticks(spoiled, contents))
    units = calibrations_of(contents.metadata, LEGS)
    assert units is not None
    offsets = replace(
        found, unloaded=faults.unloaded[:, :, :1].copy(), correction=np.zeros((6, 6, 6))
    )
    assert force_error(ticks, units, found) < 0.7 * force_error(ticks, units, offsets)


@pytest.mark.soak
def test_sound_sensors_stay_as_they_are(poses: Path, tmp_path: Path) -> None:
    out = tmp_path / "c.toml"
    assert cli.run(["force", "calibrate", str(poses), "--out", str(out)]) == ExitCode.OK
    found = read_calibration(out, LEGS)
    contents = LogContents()
    ticks = list(read_ticks(poses, contents))
    units = calibrations_of(contents.metadata, LEGS)
    assert units is not None
    none = replace(found, unloaded=np.zeros((6, 6, 1)), correction=np.zeros((6, 6, 6)))
    noise = force_error(ticks, units, none)
    assert noise < 0.035, "all that is left is the sensors' own noise"
    assert force_error(ticks, units, found) < np.hypot(noise, 0.03), "and it adds less than that"


def test_a_robot_at_rest_is_one_pose_and_a_hung_one_has_no_foot_on_the_ground() -> None:
    listen = Told(lambda t, _: STOP if t > 0.8 else wish(Intent.LISTEN))
    _, ticks, rig = drive(listen, armed=False)
    standing = find_still_poses(ticks, CONFIG, rig.calibrations, hung_up=False)
    assert len(standing) == 1
    assert not standing.in_air.any()
    assert standing.standing.all()
    assert np.isfinite(standing.lever).all()
    assert (standing.lever[..., 2] < -0.05).all(), "feet are below the shafts"
    hung = find_still_poses(ticks, CONFIG, rig.calibrations, hung_up=True)
    assert hung.in_air.all()
    assert not hung.standing.any()
    assert np.isnan(hung.lever).all()
    assert np.array_equal(hung.sensed, standing.sensed)
    both = joined([standing, hung])
    assert len(both) == 2
    assert both.standing.tolist() == [True, False]


def test_a_log_that_does_not_say_what_its_counts_mean_is_refused(tmp_path: Path) -> None:
    assert calibrations_of({}, ("A",)) is None
    for key, text in ((UNITS_KEY, '{"A": 3}'), (CALIBRATIONS_KEY, "[3]")):
        with pytest.raises(RecordError, match="cannot be read"):
            calibrations_of({key: text}, ("A",))
    path = tmp_path / "silent.mcap"
    writer = LogWriter(
        path, names=LEGS, config_text=CONFIG.text, metadata={}, start_ns=0, start_unix_ns=0
    )
    listen = Told(lambda t, _: STOP if t > 0.1 else wish(Intent.LISTEN))
    for tick in drive(listen, armed=False)[1]:
        writer.write(tick)
    writer.close()
    with pytest.raises(RecordError, match="does not say what its force counts mean"):
        read_pose_logs([path], [], None)


OLDER = (
    '{"B": {"transducer": 3, "serial": "FT3", "date": "2023/5/1", "part": "SI-130-10", '
    '"counts_per_n": 1e6, "counts_per_nm": 1e9}}'
)
TODAY = (
    '[null,{"transducer":3,"serial":"FT3","date":"2023/5/1","part":"SI-130-10","counts_per_n":1e6,'
    '"counts_per_nm":1e9,"mult_on":true,"max_rating":[1,1,1,1,1,null]}]'
)


@pytest.mark.parametrize(("key", "text"), [(UNITS_KEY, OLDER), (CALIBRATIONS_KEY, TODAY)])
def test_units_travel_with_the_log(key: str, text: str) -> None:
    back = calibrations_of({key: text}, ("A", "B"))
    assert back is not None
    assert back[0] is None
    assert back[1] is not None
    assert (back[1].transducer, back[1].serial, back[1].counts_per_nm) == (3, "FT3", 1e9)
