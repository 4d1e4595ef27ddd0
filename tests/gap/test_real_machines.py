"""Real logs that no one here made, where the folder of data sets is given by ``BIGANT_SHARED_DATA``."""

import json
import os
from pathlib import Path

import pytest

from benchmarks.real.machines import COUNT_RAD, Found, alone, bring_in, diagnose, sources
from benchmarks.real.xl330 import GAINS, of_gain, published, without_duty
from robot.cli import main as cli
from tests.soaked import THOROUGH, soaked

# one gain with each of the two maps; the others in `make thorough`
WITHOUT_DUTY, WITH_DUTY = GAINS[:2]
FOLDER = os.environ.get("BIGANT_SHARED_DATA", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="BIGANT_SHARED_DATA names no folder")


def faults_of(
    name: str, capsys: pytest.CaptureFixture[str]
) -> tuple[set[tuple[str, str]], list[Found]]:
    """Kinds and columns of all that ``bigant import`` says of a set, and its tables."""
    files = dict(sources(Path(FOLDER)))[name]
    assert cli.run(["import", *files, "--map", name, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    tables: list[Found] = told.get("tables", [told])
    kinds = {(f["kind"], f["column"]) for one in tables for f in one["findings"]}
    return kinds | {(f["kind"], f["channel"]) for one in tables for f in one["faults"]}, tables


def test_faults_of_the_rigs_data_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    found, _ = faults_of("servo_backlash", capsys)
    assert found >= {
        ("wrap", "speed (5)"), ("wrap", "load (5)"), ("wrap", "load (3)"),
        ("magnitude_only", "current_servo_a"), ("frozen", "shaft_servo_rad_s"),
    }  # fmt: skip


def test_an_empty_first_row_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The log of two servos in preload; its ids differ, so the map is written for it here."""
    log = Path(FOLDER) / "uart_servo_backlash" / "logs" / "motor_telemetry_nocomp2.csv"
    (tmp_path / "map.toml").write_text(
        "[columns]\ntime_s = { from = 'timestamp', unit = 'iso8601' }\n"
        "shaft_a_rad = { from = 'pos (1)', unit = 'ticks_4096' }\n"
        "command_a_rad = { from = 'target pos (1)', unit = 'ticks_4096' }\n"
    )
    assert cli.run(["import", str(log), "--map", str(tmp_path / "map.toml")]) == 0
    assert "empty" in capsys.readouterr().out


@pytest.mark.soak
def test_faults_of_the_arms_data_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    found, tables = faults_of("so101", capsys)
    joints = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll")
    assert found >= {("magnitude_only", f"torque_{joint}_nm") for joint in joints}
    assert found >= {("spikes", "torque_Wrist_Roll_nm"), ("ignored", "pos[5]")}
    # it rests for 3.4 s, and reads on from where it lay: held by something, not a frozen encoder
    assert ("frozen", "shaft_Wrist_Roll_rad") not in found
    assert not [f for one in tables for f in one["faults"] if f["severe"]]
    assert len(tables) == 50
    assert sum(one["kept"] for one in tables) == 225145


def test_tosses_too_short_to_slide_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    _, tables = faults_of("sliding_cube", capsys)
    short = [one for one in tables if any(f["kind"] == "short" for f in one["findings"])]
    assert (len(tables), len(short)) == (550, 92)
    assert all(one["rows"] == one["kept"] + _cut(one) for one in tables if one not in short)


def _cut(one: Found) -> int:
    return sum(f["count"] for f in one["findings"] if f["kind"] == "cut")


@pytest.mark.thorough
@pytest.mark.parametrize("joint", ["Rotation", "Elbow"])
def test_an_arm_joint_is_explained_by_more_than_a_delay(joint: str, tmp_path: Path) -> None:
    trials = bring_in(Path(FOLDER), "so101", tmp_path)
    found = diagnose(trials, tmp_path / "page.html", "--joint", joint)
    assert found["verdict"] in {"explained", "ambiguous"}
    assert "play" in {cause["effect"] for cause in found["causes"]}
    (shaft,) = found["channels"]
    assert shaft["after"] < 0.3 * shaft["before"]
    low, high = shaft["after_range"]
    assert low < shaft["after"] < high < 0.3 * shaft["before_range"][0]
    assert not any("fix the data" in words for words in found["warnings"])
    late = alone(trials, ["command_delay"], "--joint", joint)["command_delay"]
    assert late["channels"][0]["after"] > shaft["after_range"][1]
    assert (tmp_path / "page.html").stat().st_size < 2_000_000


def test_the_backlash_of_the_rig_is_the_published_one(tmp_path: Path) -> None:
    found = diagnose(bring_in(Path(FOLDER), "servo_backlash", tmp_path), tmp_path / "page.html")
    cause = found["causes"][0]
    assert cause["effect"] == "backlash"
    assert cause["parameters"]["width_rad"] / COUNT_RAD == pytest.approx(14.78, abs=1.0)


@pytest.mark.thorough
def test_the_cube_slides_by_coulombs_law(tmp_path: Path) -> None:
    found = diagnose(bring_in(Path(FOLDER), "sliding_cube", tmp_path), tmp_path / "page.html")
    assert found["causes"][0]["effect"] == "coulomb_friction"
    slowing = next(c for c in found["channels"] if c["channel"] == "deceleration")
    assert slowing["after"] < 0.4 * slowing["before"]


@pytest.mark.soak
def test_one_call_over_four_gains_names_the_published_gain(tmp_path: Path) -> None:
    """The firmware divides by 256 where the manual says 128; the gearbox's friction grows with its load."""
    trials = bring_in(Path(FOLDER), "xl330", tmp_path)
    judges = ("--hold-out", "trajectory=lift_and_drop", "--hold-out", "trajectory=sin_time_square")
    found = diagnose(trials, tmp_path / "page.html", *judges)
    assert found["data_faults"] == []
    first, second = found["causes"][:2]
    assert (first["effect"], second["effect"][-13:]) == ("controller_gain", "load_friction")
    assert first["parameters"]["ratio"] == pytest.approx(0.5, abs=0.03)
    assert all(one["probability"] <= 0.5 for one in found["causes"][2:])
    shaft = found["channels"][0]
    assert shaft["after"] < 0.4 * shaft["before"]


@pytest.mark.parametrize("gain", soaked(GAINS, WITHOUT_DUTY.__eq__, mark=THOROUGH))
def test_gain_and_motor_are_indistinguishable_without_the_duty(gain: int, tmp_path: Path) -> None:
    files = map(str, sorted((Path(FOLDER) / "xl330_pendulum").glob(f"kp{gain}_*.parquet")))
    words = ["import", *files, "--map", str(without_duty(tmp_path)), "--out", str(tmp_path / "t")]
    assert cli.run(words) == 0
    found = diagnose(of_gain(tmp_path / "t", gain), tmp_path / "told.json")
    motor = {"supply_voltage", "torque_constant", "winding_resistance"}
    alike = [set(pair) for pair in found["ambiguous_with"]]
    assert found["verdict"] == "ambiguous"
    assert any("controller_gain" in pair and pair & motor for pair in alike)


@pytest.mark.parametrize("gain", soaked(GAINS, WITH_DUTY.__eq__, mark=THOROUGH))
def test_load_friction_that_motor_constants_hide_is_named(gain: int, tmp_path: Path) -> None:
    files = map(str, sorted((Path(FOLDER) / "xl330_pendulum").glob(f"kp{gain}_*.parquet")))
    words = ["import", *files, "--map", str(published(tmp_path)), "--out", str(tmp_path / "t")]
    assert cli.run(words) == 0
    found = diagnose(of_gain(tmp_path / "t", gain), tmp_path / "told.json")
    assert any(one["effect"].endswith("load_friction") for one in found["causes"])
    shaft = found["channels"][0]
    assert shaft["after"] < shaft["before"]
