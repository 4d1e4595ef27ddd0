"""Effects of sensors and clocks: exact by hand, and undone for the stages that they feed."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gap.interfaces import Cause, Drive
from tests.gap.predictions import COULOMB, ML, Prediction, inside
from tests.gap.walks import cause, command_trial, simulator, walk

BOTH = pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)


@pytest.fixture(scope="module")
def pair() -> tuple[Prediction, dict[str, Prediction]]:
    """Base, and predictions of each sensor effect in command drive."""
    trial = walk("metachronal", 0.2, 6.0)
    effects = {
        "gain": cause("force_gain", 1.2, legs=("ML",)),
        "bias": cause("force_bias", 1.0, -2.0, 3.0, legs=("ML",)),
        "drift": cause("force_drift", 0.05, legs=("ML",)),
        "rotation": cause("force_rotation", 0.3, legs=("ML",)),
        "cross_talk": cause("force_cross_talk", 0.1, -0.05, legs=("ML",)),
        "delay": cause("force_delay", 0.08),
        "lowpass": cause("force_lowpass", 0.08),
        "pose_delay": cause("pose_delay", 0.08),
        "pose_yaw": cause("pose_yaw_offset", 0.1),
        "origin": cause("pose_origin_offset", 0.03, -0.02),
        "skew": cause("clock_skew", 1.01),
        "encoder": cause("encoder_scale", 1.02, legs=("ML",)),
    }
    return Prediction(trial), {name: Prediction(trial, [c]) for name, c in effects.items()}


def test_gain_bias_drift_touch_one_sensor(pair: tuple[Prediction, dict[str, Prediction]]) -> None:
    base, got = pair
    for axis in "xyz":
        name = f"force_{axis}"
        assert np.allclose(got["gain"][name][:, ML], 1.2 * base[name][:, ML])
        assert np.array_equal(got["gain"][name][:, ML + 1], base[name][:, ML + 1])
    assert np.allclose((got["bias"].force - base.force)[:, ML], [1.0, -2.0, 3.0])
    load_n = base["force_z"][:, ML]
    for axis, share in (("x", 0.1), ("y", -0.05), ("z", 0.0)):
        name = f"force_{axis}"
        assert np.allclose(got["cross_talk"][name][:, ML], base[name][:, ML] + share * load_n)
    drift = got["drift"]["force_z"][:, ML] - base["force_z"][:, ML]
    assert np.allclose(inside(drift, 1), inside(0.05 * base.time_s, 1))
    assert np.array_equal(got["drift"]["force_x"], base["force_x"])


def test_a_turned_transducer_mixes_x_and_y(pair: tuple[Prediction, dict[str, Prediction]]) -> None:
    base, got = pair
    x, y = base["force_x"][:, ML], base["force_y"][:, ML]
    c, s = np.cos(0.3), np.sin(0.3)
    # its own axes are turned by + yaw, so a force along body x shows along its -y
    assert np.allclose(got["rotation"]["force_x"][:, ML], c * x + s * y)
    assert np.allclose(got["rotation"]["force_y"][:, ML], c * y - s * x)
    assert np.array_equal(got["rotation"]["force_z"], base["force_z"])


def test_force_delay_and_lowpass(pair: tuple[Prediction, dict[str, Prediction]]) -> None:
    base, got = pair
    assert np.allclose(inside(got["delay"]["force_z"])[2:], inside(base["force_z"])[:-2])
    assert np.array_equal(got["delay"]["foot_x"], base["foot_x"])
    a = np.exp(-0.04 / 0.08)
    slow = lfilter([(1 - a) / 2, (1 - a) / 2], [1, -a], base["force_z"], axis=0)
    error = inside(got["lowpass"]["force_z"] - slow, 20)
    assert np.sqrt(np.mean(error**2)) < 0.03 * np.std(base["force_z"])
    assert np.array_equal(got["lowpass"]["body_vx"], base["body_vx"])


def test_motion_capture_late_turned_and_beside(
    pair: tuple[Prediction, dict[str, Prediction]],
) -> None:
    base, got = pair
    late = got["pose_delay"]
    for name in ("foot_x", "body_z", "roll", "body_vx"):
        assert np.allclose(inside(late[name], 15)[2:], inside(base[name], 15)[:-2], atol=1e-4)
    assert np.array_equal(late["force_z"], base["force_z"])
    turned, c, s = got["pose_yaw"], np.cos(0.1), np.sin(0.1)
    assert np.allclose(turned["foot_x"], c * base["foot_x"] + s * base["foot_y"])
    assert np.allclose(turned["foot_y"], c * base["foot_y"] - s * base["foot_x"])
    vx, vy = base["body_vx"], base["body_vy"]
    assert np.allclose(turned["body_vx"], c * vx + s * vy, atol=1e-6)
    assert np.allclose(turned["body_vy"], c * vy - s * vx, atol=1e-6)
    assert np.allclose(turned["body_wz"], base["body_wz"])
    beside = got["origin"]
    assert np.allclose(beside["foot_x"] - base["foot_x"], -0.03)
    assert np.allclose(beside["foot_y"] - base["foot_y"], 0.02)
    w = base["body_wz"]
    assert np.allclose(beside["body_vx"] - vx, 0.02 * w, atol=2e-4)
    assert np.allclose(beside["body_vy"] - vy, 0.03 * w, atol=2e-4)
    rise = beside["body_z"] - base["body_z"]
    assert np.allclose(rise, -0.02 * base["roll"] - 0.03 * base["pitch"], atol=1e-6)


def test_a_fast_clock_drifts_away(pair: tuple[Prediction, dict[str, Prediction]]) -> None:
    base, got = pair
    when = base.time_s / 1.01
    expected = np.interp(when, base.time_s, base["foot_x"][:, ML])
    assert np.allclose(inside(got["skew"]["foot_x"][:, ML]), inside(expected), atol=3e-4)
    assert np.array_equal(got["skew"]["force_z"], base["force_z"])


def test_a_scaled_encoder(pair: tuple[Prediction, dict[str, Prediction]]) -> None:
    base, got = pair
    trial = command_trial("metachronal", 0.2, 6.0)
    shaft = np.interp(base.time_s, trial.time_s, trial.command_rad[:, ML])
    error = got["encoder"]["shaft_error"][:, ML]
    assert np.allclose(inside(error), inside(0.02 * shaft), atol=1e-4)
    assert np.array_equal(got["encoder"]["foot_x"], base["foot_x"])


@pytest.mark.parametrize(
    "effect",
    [
        cause("force_gain", 1.3, legs=("ML",)),
        cause("force_bias", 1.0, -1.0, 3.0, legs=("ML",)),
        cause("force_drift", 0.3, legs=("ML",)),
        cause("force_rotation", 0.3, legs=("ML",)),
        cause("force_cross_talk", 0.1, -0.1, legs=("ML",)),
        cause("force_delay", 0.1),
        cause("force_lowpass", 0.1),
        cause("pose_delay", 0.1),
        cause("pose_yaw_offset", 0.15),
        cause("pose_origin_offset", 0.03, 0.02),
        cause("encoder_scale", 1.03, legs=("ML",)),
    ],
    ids=lambda c: c.effect,
)
def test_a_known_sensor_fault_does_not_reach_the_stages_that_it_feeds(effect: Cause) -> None:
    """Data with the fault, predicted from those data with the fault as a cause: as without both."""
    healthy = walk("metachronal", 0.2, 6.0, [COULOMB])
    broken = walk("metachronal", 0.2, 6.0, [COULOMB, effect])
    names = ("force_x", "force_y", "force_z", "foot_x", "body_vx", "shaft_error")
    told = Prediction(broken, [COULOMB, effect], Drive.MEASURED)
    command = Prediction(healthy, [COULOMB, effect], Drive.COMMAND)
    silent = Prediction(healthy, [COULOMB], Drive.MEASURED)
    reference = Prediction(healthy, [COULOMB], Drive.COMMAND)
    for name in names:
        far = np.sqrt(np.mean(inside(told[name] - command[name], 20) ** 2))
        healthy_far = np.sqrt(np.mean(inside(silent[name] - reference[name], 20) ** 2))
        assert far < 1.5 * healthy_far + 0.02 * np.std(reference[name]) + 1e-6, name


@pytest.mark.parametrize(
    ("effect", "names"),
    [
        (cause("force_rotation", 0.3, legs=("ML",)), ("force_x", "force_y")),
        (cause("pose_yaw_offset", 0.2), ("roll", "pitch")),
        (cause("pose_origin_offset", 0.05, 0.04), ("body_z",)),
    ],
    ids=lambda c: getattr(c, "effect", ""),
)
def test_turned_axes_mix_what_was_there_and_not_what_was_predicted(
    effect: Cause, names: tuple[str, ...]
) -> None:
    """What the simulator misses of the machine stays as it is without the fault, axis by axis."""
    unknown = (COULOMB, cause("ground_slope", 0.06, -0.04), cause("friction_level", 0.6))
    healthy = walk("metachronal", 0.2, 6.0, unknown)
    broken = walk("metachronal", 0.2, 6.0, (*unknown, effect))
    told = Prediction(broken, [effect], Drive.MEASURED)
    silent = Prediction(healthy, [], Drive.MEASURED)
    blind = Prediction(broken, [], Drive.MEASURED)
    for name in names:
        at = [k for k, channel in enumerate(simulator().channels) if channel.name == name]
        here, there = (
            simulator().observe(one).values[:, at].squeeze() for one in (healthy, broken)
        )
        missed = inside(here - silent[name], 20)
        left, unexplained = (inside(there - one[name], 20) for one in (told, blind))
        assert np.abs(unexplained - missed).max() > 0.1 * np.abs(missed).max(), "the fault shows"
        assert np.allclose(left, missed, atol=0.01 * np.abs(missed).max()), name
