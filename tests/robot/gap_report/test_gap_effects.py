"""``bigant gap effects``: the list for people and for programs, and wrong input."""

import json
from pathlib import Path

import pytest

from record.trial.trial import write_trial
from robot.cli.main import run
from tests.gap.mjcf_arms import arm_log


def test_the_list_names_every_effect_and_its_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects"]) == 0
    text = capsys.readouterr().out
    assert "ACTUATION\n  command_delay  (whole robot)\n      delay_s: 0 to 0.3 s, neutral 0" in text
    assert "47 effects" in text
    assert max(len(line) for line in text.splitlines()) <= 108


def test_json_has_units_bounds_and_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects", "--json", "--stage", "sensing"]) == 0
    effects = json.loads(capsys.readouterr().out)
    assert [e["effect"] for e in effects][:2] == ["force_gain", "force_bias"]
    assert effects[0]["scopes"] == ["leg"]
    assert effects[0]["parameters"][0]["name"] == "ratio"
    assert effects[0]["parameters"][0]["neutral"] == 1.0
    assert all(e["physics"] and e["remedy"] for e in effects)


def test_the_list_of_a_machine_is_that_of_a_run_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trial = tmp_path / "run.parquet"
    write_trial(arm_log(2.0), trial)
    assert run(["gap", "effects", str(trial)]) == 0
    text = capsys.readouterr().out
    assert "motor_strength  (whole machine, single joints)" in text
    assert "payload  (single bodies)" in text
    assert run(["gap", "effects", str(trial), "--json", "--stage", "motor"]) == 0
    motor = [one["effect"] for one in json.loads(capsys.readouterr().out)]
    assert motor[0] == "armature"
    assert "motor_strength" in motor
    assert run(["gap", "effects", str(trial), "--stage", "friction"]) == 2
    assert "stages are controller, motor, transmission, load, sensing" in capsys.readouterr().err


def test_a_machine_without_a_run_and_a_run_that_is_none_say_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["gap", "effects", "--machine", "arm.xml"]) == 2
    assert "needs a run of that machine" in capsys.readouterr().err
    assert run(["gap", "effects", str(tmp_path / "nothing.parquet")]) != 0
    assert "nothing.parquet" in capsys.readouterr().err


SHARED = """
actuation command_delay delay_s all
actuation servo_lag time_constant_s all,leg
actuation servo_speed_limit limit_rad_s all,leg
actuation servo_compliance rad_per_nm all,leg
actuation servo_compliance_beyond_encoder rad_per_nm all,leg
actuation gear_backlash width_rad leg
actuation gear_backlash_in_loop width_rad leg
actuation gear_backlash_dragged width_rad leg
actuation gear_backlash_beyond_encoder width_rad leg
actuation joint_friction behind_rad all,leg
actuation shaft_zero_offset offset_rad leg
kinematics link_length crank_m,coupler_m,rocker_m all,leg
kinematics hip_mount_offset x_m,y_m leg
kinematics leg_flex lateral_m_per_n,longitudinal_m_per_n all
support leg_stiffness ratio leg
support ground_stiffness ratio all
support leg_length offset_m leg
support ground_slope slope_x,slope_y all
support ground_step height_m,x_m all
support com_offset x_m,y_m all
support payload mass_kg,x_m,y_m all
support chassis_twist rad_per_nm all
friction foot_friction ratio leg
friction friction_level ratio all
friction friction_anisotropy w_x,w_y all,leg
friction coulomb_friction - all
friction stiction static_ratio,speed_m_s all
friction stick_slip static_ratio all
friction friction_patch ratio,x_m all
friction foot_rolling radius_m all
friction tilt_coupling - all
dynamics inertia_lag time_constant_s all
external tether_force x_n,y_n all
external drag n_s_per_m all
sensing force_gain ratio leg
sensing force_bias x_n,y_n,z_n leg
sensing force_drift n_per_s leg
sensing force_rotation yaw_rad leg
sensing force_cross_talk x_share,y_share leg
sensing force_delay delay_s all
sensing force_lowpass time_constant_s all
sensing pose_delay delay_s all
sensing pose_yaw_offset yaw_rad all
sensing pose_origin_offset x_m,y_m all
sensing marker_on_shank share all
sensing clock_skew ratio all
sensing encoder_scale ratio leg
"""


def test_stages_parameters_and_scopes_are_those_that_diagnoses_share(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["gap", "effects", "--json"]) == 0
    listed = [
        " ".join([
            one["stage"],
            one["effect"],
            ",".join(p["name"] for p in one["parameters"]) or "-",
            ",".join(one["scopes"]),
        ])
        for one in json.loads(capsys.readouterr().out)
    ]  # fmt: skip
    assert listed == SHARED.split("\n")[1:-1]


def test_wrong_input_is_one_clear_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects", "--stage", "magic"]) != 0
    assert "stages are actuation, kinematics" in capsys.readouterr().err
    assert run(["gap", "effects", "--effects", str(tmp_path / "none.py")]) != 0
    err = capsys.readouterr().err
    assert "there is no file" in err
    assert len(err.strip().splitlines()) == 1
