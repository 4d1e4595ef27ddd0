"""The sensitivity command: logs whose truth is known, logs of the virtual robot, and wrong input."""

import json
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.faults import StopReason
from model.values.machine_names import one_joint_a_leg
from model.values.parameters import ContactParameters
from model.values.tick import Intent, Mode
from record.log.recording import Recording, build_recording
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.report.walk_frames import fit_contact, halves, joined, smooth_rate, walk_frames
from robot.study.sensitivity import compare
from tests.gap.test_correction import corrected
from tests.gap.walks import cause
from tests.robot.runs import Told, drive, wish

CONFIG = load_robot()
LEGS = CONFIG.parameters.legs
TRUE = ContactParameters(
    np.array([2300.0, 2500.0, 2700.0, 2400.0, 2600.0, 2500.0]),
    np.array([0.8, 1.0, 1.2, 1.1, 0.9, 1.0]),
    np.array([[0.6, 0.0], [0.9, 0.0], [0.7, 0.0], [0.8, 0.0], [0.5, 0.0], [0.6, 0.0]]),
)
WEIGHT = 64.0


def synthetic(
    ticks: int = 600,
    *,
    truth: bool = True,
    forces: bool = True,
    law: FrictionLaw = FrictionLaw.VISCOUS,
) -> Recording:
    """A log of a robot that the model describes exactly."""
    t: FloatArray = np.arange(ticks, dtype=np.float64) / 100
    legs = LEGS.count
    swing = 2 * np.pi * np.outer(t, 0.2 + 0.03 * np.arange(legs)) + np.arange(legs)
    angle, rate = 0.4 * np.sin(swing), 0.4 * np.cos(swing) * np.gradient(swing, t, axis=0)
    feet = leg_kinematics(CONFIG.parameters).feet(angle, rate)
    solved = solve_frames(feet, TRUE, WEIGHT, law=law)
    assert solved.valid.all()
    x, y = solved.pose[:, 1] / 2, solved.pose[:, 0] / 2
    quaternion = np.stack([x, y, 0 * x, np.sqrt(1 - x**2 - y**2)], axis=1)
    scale = 40.0 if law is FrictionLaw.VISCOUS else 1.0
    force = np.concatenate([scale * solved.force_xy_B, solved.load_n[..., None]], axis=2)
    known, measured = (1.0 if truth else np.nan), (1.0 if forces else np.nan)

    def empty(*shape: int) -> FloatArray:
        return np.full((ticks, *shape), np.nan)

    return Recording(
        names=LEGS.names,
        joints=LEGS.names,
        t_s=t,
        mode=np.full(ticks, Mode.WALK.value),
        stop_reason=np.zeros(ticks, dtype=np.int64),
        gait_phase=t,
        angle_rad=angle,
        rate_rad_s=rate,
        current_a=empty(legs),
        temperature_c=empty(legs),
        sent_angle_rad=angle,
        force_n=measured * force,
        predicted_force_n=empty(legs, 3),
        predicted_velocity_B=empty(3),
        predicted_slip_B=empty(legs, 2),
        dead_reckoning_pose=empty(3),
        estimate_pose=empty(3),
        estimate_pose_sd=empty(3),
        estimate_velocity_B=empty(3),
        estimate_force_n=empty(legs, 3),
        estimate_health=np.full(ticks, -1),
        gyro_bias=empty(2),
        imu=empty(3),
        truth_position_W=known * np.zeros((ticks, 3)),
        truth_quaternion_xyzw=known * quaternion,
        truth_velocity_B=known * solved.velocity_B,
        truth_foot_velocity_W=known * np.concatenate([solved.slip_B, 0 * force[..., :1]], axis=2),
        truth_force_n=known * force,
        truth_contact=solved.contact,
        lateness_s=empty(),
        busy_s=empty(),
        missed=np.zeros(ticks, dtype=np.int64),
        faults=(),
        config_text=DEFAULT_ROBOT_FILE.read_text(encoding="utf-8"),
        metadata=MappingProxyType({}),
        damage="",
    )


@pytest.mark.parametrize("free_w", [False, True])
def test_the_truth_is_fitted_and_judged_on_other_frames(free_w: bool) -> None:
    earlier, later = halves(walk_frames(synthetic(), "log"))
    fits = fit_contact(earlier, LEGS.names, free_w=free_w, rest_m_s=0.0)
    assert fits.weight_n == pytest.approx(WEIGHT)
    assert fits.contact.stiffness == pytest.approx(TRUE.stiffness, rel=0.01)
    assert fits.contact.mu == pytest.approx(TRUE.mu / TRUE.mu.mean(), rel=1e-3)
    assert fits.contact.anisotropy == pytest.approx(TRUE.anisotropy, abs=1e-3)
    assert len(fits.stiffness.names) + len(fits.friction.names) == (24 if free_w else 18)
    found = compare(later, fits)
    assert found.frames + found.without_answer == later.count
    assert (found.fitted < 0.1 * found.naive).all()
    assert (found.change > 0).all()
    assert found.clamped[0] == 0


def test_coulombs_law_is_fitted_in_newtons() -> None:
    walk = walk_frames(synthetic(law=FrictionLaw.COULOMB), "log")
    earlier, later = halves(walk)
    fits = fit_contact(earlier, LEGS.names, free_w=False, rest_m_s=1e-3, law=FrictionLaw.COULOMB)
    assert fits.contact.mu == pytest.approx(TRUE.mu, rel=1e-3)
    assert fits.contact.anisotropy == pytest.approx(TRUE.anisotropy, abs=1e-3)
    found = compare(later, fits)
    assert (found.fitted < found.naive).all()
    assert found.clamped == (0, 0)


def test_velocities_are_smoothed_as_in_the_paper() -> None:
    log = synthetic()
    inner = slice(12, -12)
    assert smooth_rate(log)[inner] == pytest.approx(log.rate_rad_s[inner], abs=0.01)
    log.t_s[300:] += 0.05
    rate = smooth_rate(log)
    assert np.isnan(rate[290:310]).all()
    assert np.isfinite(rate[:280]).all()


def test_halves_and_joined_are_inverse() -> None:
    walk = walk_frames(synthetic(101), "log")
    assert joined(halves(walk)).force == pytest.approx(walk.force)


@pytest.mark.parametrize(
    ("truth", "forces", "words"), [(False, True, "no true body motion"), (True, False, "no foot")]
)
def test_a_log_that_cannot_be_used_is_refused(
    truth: bool,
    forces: bool,
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(
        "robot.study.sensitivity.read_log", lambda path: synthetic(50, truth=truth, forces=forces)
    )
    assert cli.run(["model", "sensitivity", "some.mcap"]) == ExitCode.LOG
    complaint = capsys.readouterr().err
    assert f"some.mcap has {words}" in complaint
    assert complaint.count("\n") == 1


def test_effects_of_the_sensors_are_taken_out_and_those_of_the_robot_refused() -> None:
    plain = synthetic(60)
    biased = plain.force_n.copy()
    biased[:, 1, 2] -= 3.0
    file = corrected(plain.config_text, cause("force_bias", 0.0, 0.0, -3.0, legs=(LEGS.names[1],)))
    walk = walk_frames(replace(plain, force_n=biased, config_text=file), "log")
    assert np.allclose(walk.force, walk_frames(plain, "log").force)
    heavier = corrected(plain.config_text, cause("payload", 0.5, 0.0, 0.0))
    with pytest.raises(ConfigError, match="log was walked with payload in its robot file"):
        walk_frames(replace(plain, config_text=heavier), "log")
    late = corrected(plain.config_text, cause("command_delay", 0.03))
    assert walk_frames(replace(plain, config_text=late), "log").count == walk.count


def test_wrong_input_is_one_clear_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = str(tmp_path / "none.mcap")
    assert cli.run(["model", "sensitivity", missing]) == ExitCode.LOG
    assert "none.mcap cannot be read" in capsys.readouterr().err
    assert cli.run(["model", "sensitivity", missing, "--out", "a.jpg"]) == ExitCode.USAGE
    assert "must end in .png" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.run(["model", "sensitivity", missing, "--rest-mm-s", "-1"])


def test_the_table_and_the_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("robot.study.sensitivity.read_log", lambda path: synthetic())
    picture = tmp_path / "change.png"
    words = ["model", "sensitivity", "a.mcap", "b.mcap", "c.mcap", "--out", str(picture)]
    assert cli.run(words) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "fitted to a.mcap, 600 frames" in printed
    assert "judged by b.mcap, c.mcap, 1200 frames" in printed
    for word in ("heading", "turning", "pitch", "Fz", "-22.0", "K HL", "w FR", "+-"):
        assert word in printed
    assert picture.read_bytes().startswith(b"\x89PNG")


def walked() -> Recording:
    """Some seconds of the virtual robot; torque is cut in mid-walk, to save the way to a stand."""
    cut = wish(Intent.CUT, reason=StopReason.OPERATOR)
    walk = wish(Intent.WALK, frequency_hz=0.2)
    _, ticks, _ = drive(Told(lambda t, _: cut if t > 3.4 else walk))
    return build_recording(
        ticks,
        machine=one_joint_a_leg(LEGS.names),
        start_ns=ticks[0].t_ns,
        config_text=DEFAULT_ROBOT_FILE.read_text(encoding="utf-8"),
        metadata=MappingProxyType({}),
        damage="",
    )


def test_a_log_of_the_virtual_robot(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = walked()
    monkeypatch.setattr("robot.study.sensitivity.read_log", lambda path: log)
    assert cli.run(["model", "sensitivity", "walk.mcap", "--json"]) == ExitCode.OK
    found = json.loads(capsys.readouterr().out)
    assert [row["quantity"] for row in found["rmse"]][:3] == ["heading", "side", "turning"]
    assert found["fitted_to"]["weight_n"] == pytest.approx(6.5 * 9.81, rel=0.03)
    assert found["fitted_to"]["frames"] + found["judged_by"]["frames"] <= 250
    names = {row["name"] for row in found["friction"]["parameters"]}
    assert set(found["friction"]["undetermined"]) <= names
    for row in found["friction"]["parameters"]:
        undetermined = row["name"] in found["friction"]["undetermined"]
        assert (row["standard_error"] is None) == undetermined
