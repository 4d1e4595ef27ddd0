"""The compiled batch: equal to numpy frame by frame, gaps kept apart, and with or without a compiler."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from model import compiled
from model.errors import ModelError
from model.quasistatic.frame import solve_frame, solve_walk
from model.quasistatic.frames import FrictionLaw, Reason, solve_frames
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.coulomb_frames import frames
from tests.model.oracles.traction import solve_frame_reference

WEIGHT_N = 60.0
ROOT = Path(__file__).resolve().parents[2]


def contact(legs: int, seed: int = 0) -> ContactParameters:
    rng = np.random.default_rng(seed)
    return ContactParameters(
        rng.uniform(1500, 3500, legs),
        rng.uniform(0.3, 1.0, legs),
        rng.normal(scale=0.4, size=(legs, 2)),
    )


def close(one: FloatArray, other: FloatArray, size: float) -> None:
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("legs", [3, 4, 6, 12, 50])
def test_one_frame_and_many_agree_with_numpy(legs: int) -> None:
    feet = frames("random", 60, legs, np.random.default_rng(legs))
    believed = contact(legs)
    many = solve_frames(feet, believed, WEIGHT_N)
    for i in range(60):
        motion = FootMotion(feet.position_m[i], feet.velocity_m_s[i])
        expected = solve_frame_reference(motion, believed, WEIGHT_N)
        single = solve_frame(motion, believed, WEIGHT_N)
        assert single.support.converged == expected.support.converged
        assert single.traction.valid == expected.traction.valid
        assert single.support.contact.tolist() == expected.support.contact.tolist()
        close(single.support.load_n, expected.support.load_n, WEIGHT_N)
        close(single.traction.velocity_B, expected.traction.velocity_B, 1.0)
        close(single.traction.slip_B, expected.traction.slip_B, 1.0)
        close(single.traction.force_B, expected.traction.force_B, 10 * WEIGHT_N)
        assert single.support.slope_x == pytest.approx(expected.support.slope_x, abs=1e-12)
        assert single.support.height_m == pytest.approx(expected.support.height_m, abs=1e-12)
        if expected.traction.valid:
            close(many.velocity_B[i], expected.traction.velocity_B, 1.0)
            close(many.load_n[i], expected.support.load_n, WEIGHT_N)


def test_a_gap_stays_in_its_frame() -> None:
    feet = frames("random", 5, 6, np.random.default_rng(0))
    whole = solve_frames(feet, contact(6), WEIGHT_N)
    position, velocity = feet.position_m.copy(), feet.velocity_m_s.copy()
    position[1, 2, 0] = np.nan
    velocity[2, 3, 2] = np.inf
    position[3, :, 0] += 5.0
    for law in FrictionLaw:
        whole = solve_frames(feet, contact(6), WEIGHT_N, law=law)
        holed = solve_frames(FootMotion(position, velocity), contact(6), WEIGHT_N, law=law)
        reasons = [Reason.FINE, Reason.NOT_A_NUMBER, Reason.NOT_A_NUMBER, Reason.TIPS, Reason.FINE]
        assert holed.reason.tolist() == reasons
        assert holed.valid.tolist() == [True, False, False, False, True]
        assert np.isnan(holed.velocity_B[1:4]).all()
        assert np.isnan(holed.force_xy_B[1:4]).all()
        assert np.isnan(holed.load_n[[1, 3]]).all()
        assert np.isfinite(holed.load_n[2]).all(), "loads need no velocity"
        close(holed.velocity_B[4], whole.velocity_B[4], 1.0)
        assert not holed.unique[1:4].any()


def test_reasons_for_parameters() -> None:
    feet = frames("random", 2, 6, np.random.default_rng(0))
    fine = contact(6)
    assert (solve_frames(feet, fine, 0.0).reason == Reason.NEGATIVE).all()
    assert (solve_frames(feet, fine, np.nan).reason == Reason.NOT_A_NUMBER).all()
    slack = ContactParameters(np.zeros(6), fine.mu, fine.anisotropy)
    assert (solve_frames(feet, slack, 60.0).reason == Reason.NEGATIVE).all()
    empty = ContactParameters(np.zeros(0), np.zeros(0), np.zeros((0, 2)))
    none = FootMotion(np.zeros((2, 0, 3)), np.zeros((2, 0, 3)))
    assert (solve_frames(none, empty, 60.0).reason == Reason.NO_FEET).all()
    one = FootMotion(np.array([[[0.0, 0.0, -0.1]]]), np.zeros((1, 1, 3)))
    single = ContactParameters(np.ones(1) * 1e3, np.ones(1), np.zeros((1, 2)))
    answer = solve_frames(one, single, 60.0)
    assert answer.reason.tolist() == [Reason.TOO_FEW_FEET]
    assert answer.load_n[0, 0] == pytest.approx(60.0), "it stands, but how it turns nobody knows"
    pair = FootMotion(np.zeros((1, 2, 3)), np.zeros((1, 2, 3)))
    twice = ContactParameters(np.ones(2) * 1e3, np.ones(2), np.zeros((2, 2)))
    assert solve_frames(pair, twice, 60.0).reason.tolist() == [Reason.ONE_POINT]


def test_feet_in_a_line_still_turn() -> None:
    """All feet on a line through the centre of mass: turning is resisted, and determined."""
    feet = np.array([[-0.3, 0.0, -0.1], [0.0, 0.0, -0.1], [0.3, 0.0, -0.1]])
    speed = np.zeros((3, 3))
    speed[:, 1] = -0.5 * feet[:, 0]
    believed = ContactParameters(np.full(3, 1e3), np.full(3, 0.5), np.zeros((3, 2)))
    for law in FrictionLaw:
        answer = solve_frames(FootMotion(feet[None], speed[None]), believed, 30.0, law=law)
        np.testing.assert_allclose(answer.velocity_B[0], [0, 0, 0.5], atol=1e-12)


def test_tilt_coupling_adds_the_vertical_speed_along_the_slope() -> None:
    """Erratum E2: [slope_x, -slope_y] q'_z joins the horizontal foot velocities."""
    feet = frames("random", 200, 6, np.random.default_rng(8))
    velocity = feet.velocity_m_s.copy()
    velocity[..., 2] = np.random.default_rng(9).normal(scale=0.3, size=velocity.shape[:2])
    with_it = solve_frames(
        FootMotion(feet.position_m, velocity), contact(6), WEIGHT_N, tilt_coupling=True
    )
    slope = with_it.pose[:, None, :2] * [1.0, -1.0]
    by_hand = velocity.copy()
    by_hand[..., :2] += slope * velocity[..., 2:]
    without = solve_frames(FootMotion(feet.position_m, by_hand), contact(6), WEIGHT_N)
    close(with_it.velocity_B, without.velocity_B, 1.0)
    plain = solve_frames(FootMotion(feet.position_m, velocity), contact(6), WEIGHT_N)
    assert np.abs(plain.velocity_B - with_it.velocity_B).max() > 1e-4


def test_anisotropy_may_turn_from_frame_to_frame() -> None:
    feet = frames("random", 4, 6, np.random.default_rng(2))
    turning = np.random.default_rng(3).normal(scale=0.5, size=(4, 6, 2))
    fine = contact(6)
    for law in FrictionLaw:
        together = solve_frames(feet, fine, WEIGHT_N, law=law, anisotropy_B=turning)
        for i in range(4):
            alone = ContactParameters(fine.stiffness, fine.mu, turning[i])
            one = FootMotion(feet.position_m[i : i + 1], feet.velocity_m_s[i : i + 1])
            expected = solve_frames(one, alone, WEIGHT_N, law=law)
            close(together.velocity_B[i], expected.velocity_B[0], 10.0)
    with pytest.raises(ModelError, match="anisotropy must be"):
        solve_frames(feet, fine, WEIGHT_N, anisotropy_B=turning[:2])


def test_wrong_shapes_say_so() -> None:
    feet = frames("random", 2, 6, np.random.default_rng(0))
    with pytest.raises(ModelError, match="frames, legs, 3"):
        solve_frames(FootMotion(feet.position_m[0], feet.velocity_m_s[0]), contact(6), 60.0)
    with pytest.raises(ModelError, match="6 feet need"):
        solve_frames(feet, contact(5), 60.0)
    with pytest.raises(ModelError, match="the ground must be"):
        solve_frames(feet, contact(6), 60.0, ground_m=np.zeros(4))
    with pytest.raises(ModelError, match=r"\(N, 3\)"):
        solve_frame(feet, contact(6), 60.0)


def test_a_walk_is_solved_as_its_frames_are_to_the_bit() -> None:
    feet = frames("random", 40, 6, np.random.default_rng(3))
    position, speed = feet.position_m.copy(), feet.velocity_m_s.copy()
    position[3], speed[4, 1], speed[5] = np.nan, np.nan, 0.0
    position[6, :, 0] += 1.0  # it tips
    walk = solve_walk(FootMotion(position, speed), contact(6), WEIGHT_N)
    for frame in range(len(position)):
        one = solve_frame(FootMotion(position[frame], speed[frame]), contact(6), WEIGHT_N)
        np.testing.assert_array_equal(walk.velocity_B[frame], one.traction.velocity_B)
        np.testing.assert_array_equal(walk.force_B[frame], one.traction.force_B)
        np.testing.assert_array_equal(walk.height_m[frame], one.support.height_m)
    assert np.isnan(walk.velocity_B[[3, 4, 6]]).all()
    assert np.isfinite(walk.velocity_B[[0, 5]]).all()
    with pytest.raises(ModelError, match="not"):
        solve_walk(FootMotion(position[:, :5], speed[:, :5]), contact(6), WEIGHT_N)


WITHOUT = """
import sys
sys.modules["numba"] = None
import numpy as np
from model.compiled import compiles
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.quasistatic.frame import prepare, solve_frame
from model.values.legs import FootMotion
from tests.model.coulomb_frames import frames
from tests.model.test_frames import WEIGHT_N, contact
assert not compiles()
prepare()
feet = frames("random", 25, 6, np.random.default_rng(1))
out = [solve_frames(feet, contact(6), WEIGHT_N, law=law).velocity_B for law in FrictionLaw]
one = solve_frame(FootMotion(feet.position_m[0], feet.velocity_m_s[0]), contact(6), WEIGHT_N)
np.savez(sys.argv[1], viscous=out[0], coulomb=out[1], one=one.traction.velocity_B)
"""


def test_without_a_compiler_it_gives_the_same(tmp_path: Path) -> None:
    path = tmp_path / "out.npz"
    subprocess.run([sys.executable, "-c", WITHOUT, str(path)], cwd=ROOT, check=True)
    feet = frames("random", 25, 6, np.random.default_rng(1))
    plain = np.load(path)
    for law in FrictionLaw:
        fast = solve_frames(feet, contact(6), WEIGHT_N, law=law)
        close(plain[law.value], fast.velocity_B, 1.0)
    close(plain["one"], solve_frames(feet, contact(6), WEIGHT_N).velocity_B[0], 1.0)


@pytest.mark.skipif(not compiled.compiles(), reason="numba is not installed")
@pytest.mark.parametrize("module", ["model.estimator.frame_kernel", "sim_hw.plant.leg_kernel"])
def test_the_sources_of_a_kernel_are_all_that_an_interpreter_loads_for_it(module: str) -> None:
    """Importing the module alone loads no module of these packages that its stamp does not know."""
    top = module.split(".")[0]
    code = (
        f"import sys, {module}\n"
        f"print(*[m for m in sys.modules if m.split('.')[0] in ('model', '{top}')])"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split()
    sources = compiled.sources_of(module)
    modules = {name for name in loaded if (ROOT / f"{name.replace('.', '/')}.py").exists()}
    assert modules <= sources.keys()
    assert "model.values.arrays" in modules
