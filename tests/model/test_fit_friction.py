"""Friction from forces and slips: derivatives, recovery, honest errors, and what cannot be told."""

from dataclasses import dataclass

import numpy as np
import pytest

from model.errors import ModelError
from model.fit.friction import FrictionFit, FrictionForm, fit_friction
from model.fit.friction_search import FrictionSearch, choose_contacts
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray

NAMES = ("HL", "ML", "FL", "HR", "MR", "FR")
MU = np.array([0.8, 1.0, 1.1, 1.3, 1.0, 0.8])
W = np.array([[0.8, 0.3], [0.5, -0.4], [0.6, 0.6], [1.0, 0.0], [0.7, 0.2], [0.4, 0.9]])
ALONG = W / np.linalg.norm(W, axis=1)[:, None]
VISCOUS, COULOMB = FrictionLaw.VISCOUS, FrictionLaw.COULOMB


@dataclass
class Walk:
    load: FloatArray
    slip: FloatArray

    def force(self, law: FrictionLaw, w: FloatArray = W) -> FloatArray:
        matrix = np.eye(2) + w[:, :, None] * w[:, None, :]
        motion = np.einsum("kij,fkj->fki", matrix, self.slip)
        if law is COULOMB:
            size = np.linalg.norm(motion, axis=2, keepdims=True)
            motion = np.einsum("kij,fkj->fki", matrix, motion / np.where(size > 0, size, 1))
        force: FloatArray = -(MU * self.load)[..., None] * motion
        if law is VISCOUS:
            force *= np.random.default_rng(9).uniform(20, 60, (len(force), 1, 1))
        return force


def walk(seed: int, frames: int = 150) -> Walk:
    rng = np.random.default_rng(seed)
    load = rng.uniform(0, 20, (frames, 6))
    load[rng.random(load.shape) < 0.3] = 0.0
    return Walk(load, rng.normal(0, 0.02, (frames, 6, 2)))


def fit(data: Walk, force: FloatArray, law: FrictionLaw, **more: object) -> FrictionFit:
    options: dict[str, object] = {"law": law, "mean_mu": 1.0 if law is VISCOUS else None}
    form = FrictionForm(**(options | more))  # type: ignore[arg-type]
    return fit_friction(force, data.load, data.slip, form, leg_names=NAMES)


@pytest.mark.parametrize("direction", [None, ALONG], ids=["24", "18"])
@pytest.mark.parametrize("scaled", [True, False])
@pytest.mark.parametrize("law", [VISCOUS, COULOMB])
def test_jacobian_agrees_with_differences(
    law: FrictionLaw, direction: FloatArray | None, scaled: bool
) -> None:
    data, step = walk(0), 1e-6
    force = data.force(law) + np.random.default_rng(1).normal(0, 2, (len(data.load), 6, 2))
    contacts, _ = choose_contacts(force, data.load, data.slip, law, 0.0)
    search = FrictionSearch(contacts, direction, frame_scale=scaled)
    theta = search.start() + 0.1
    differences = np.stack(
        [
            (search.residual(theta + step * one) - search.residual(theta - step * one)) / (2 * step)
            for one in np.eye(len(theta))
        ],
        axis=1,
    )
    analytic = search.jacobian(theta)
    assert np.abs(analytic - differences).max() < 1e-7 * np.abs(analytic).max()


@pytest.mark.parametrize("law", [VISCOUS, COULOMB])
@pytest.mark.parametrize("direction", [None, -3.0 * ALONG], ids=["24", "18"])
def test_the_truth_is_found_without_noise(law: FrictionLaw, direction: FloatArray | None) -> None:
    data = walk(2)
    found = fit(data, data.force(law), law, direction=direction)
    assert found.mu == pytest.approx(MU, rel=1e-8)
    sign = 1.0 if direction is None else -1.0  # a length along a given direction is not negative
    assert found.anisotropy == pytest.approx(sign * W, abs=1e-8)
    assert found.result.converged
    assert found.result.undetermined == ()
    assert found.result.warnings == ()
    assert len(found.result.names) == (18 if direction is None else 12)
    assert found.result.left_out[0][0].startswith("not loaded")


@pytest.mark.parametrize(
    ("law", "direction"),
    [
        pytest.param(COULOMB, None, id="24-coulomb"),
        pytest.param(VISCOUS, ALONG, id="18-viscous"),
        pytest.param(VISCOUS, None, id="24-viscous", marks=pytest.mark.soak),
        pytest.param(COULOMB, ALONG, id="18-coulomb", marks=pytest.mark.soak),
    ],
)
def test_standard_errors_cover_the_truth(law: FrictionLaw, direction: FloatArray | None) -> None:
    data = walk(3)
    clean = data.force(law)
    rng = np.random.default_rng(0)
    true = np.append(MU, W.ravel() if direction is None else np.linalg.norm(W, axis=1))
    scores = []
    for _ in range(25):
        found = fit(data, clean + rng.normal(0, 0.8, clean.shape), law, direction=direction)
        assert found.result.undetermined == ()
        scores.append((found.result.values - true) / found.result.standard_errors)
    z = np.abs(np.array(scores))
    assert 0.8 < np.sqrt(np.mean(z**2)) < 1.2
    assert (z < 3).mean() > 0.98


def test_the_common_scale_of_mu_is_a_convention() -> None:
    data = walk(5)
    found = fit(data, data.force(VISCOUS), VISCOUS, mean_mu=None)
    assert found.result.undetermined == tuple(f"mu {name}" for name in NAMES)
    assert "common scale of mu" in found.result.warnings[0]
    assert np.isnan(found.result.standard_errors[:6]).all()
    assert np.isfinite(found.result.standard_errors[6:]).all()
    assert found.mu == pytest.approx(MU / MU.mean())


def test_forces_in_newtons_show_the_scale_of_the_ansatz() -> None:
    data = walk(5)
    along = np.einsum("ki,fki->fk", W, data.slip)[..., None]
    force = -40.0 * (MU * data.load)[..., None] * (data.slip + along * W)
    found = fit(data, force, VISCOUS, mean_mu=None, frame_scale=False)
    assert found.mu == pytest.approx(40.0 * MU)
    assert found.result.undetermined == ()


@pytest.mark.parametrize("law", [VISCOUS, COULOMB])
@pytest.mark.parametrize("what", ["never loaded", "never slipped"])
def test_a_leg_without_data_is_not_known(law: FrictionLaw, what: str) -> None:
    data = walk(6)
    if what == "never loaded":
        data.load[:, 1] = 0.0
    else:
        data.slip[:, 1] = 0.0
    found = fit(data, data.force(law), law).result
    assert found.undetermined == ("mu ML", "w_x ML", "w_y ML")
    assert found.warnings == (f"leg ML was {what}, so that its friction is not known",) or (
        found.warnings == (f"leg ML {what}, so that its friction is not known",)
    )
    assert np.isnan(found.standard_errors[[1, 8, 9]]).all()
    assert np.isfinite(np.delete(found.standard_errors, [1, 8, 9])).all()


@pytest.mark.parametrize("direction", [None, np.tile([1.0, 0.0], (6, 1))], ids=["24", "18"])
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_a_leg_that_slips_one_way_does_not_tell_mu_from_w(
    direction: FloatArray | None, noise: float
) -> None:
    data = walk(7)
    data.slip[:, 2, 1] = 0.0
    w = W if direction is None else W * [1.0, 0.0]
    force = data.force(COULOMB, w)
    force += noise * np.random.default_rng(0).normal(0, 1, force.shape)
    found = fit(data, force, COULOMB, direction=direction).result
    expected = {"mu FL", "w_x FL", "w_y FL"} if direction is None else {"mu FL", "w FL"}
    # a w that is all noise may be called isotropic besides; the leg in question must be named
    assert expected <= set(found.undetermined)
    assert not {name for name in found.undetermined if name.startswith("mu")} - {"mu FL"}
    assert any("mu and w of leg FL are indistinguishable" in line for line in found.warnings)


def test_an_isotropic_leg_has_no_w() -> None:
    data = walk(8)
    w = W.copy()
    w[3] = 0.0
    force = data.force(COULOMB, w)
    force += np.random.default_rng(0).normal(0, 0.5, force.shape)
    found = fit(data, force, COULOMB)
    assert found.result.undetermined == ("w_x HR", "w_y HR")
    assert "w of leg HR is indistinguishable from 0" in found.result.warnings[0]
    assert found.mu[3] == pytest.approx(MU[3], rel=0.05)


def test_feet_at_rest_are_left_out_of_coulombs_law() -> None:
    data = walk(9)
    force = data.force(COULOMB)
    rests = np.random.default_rng(1).random(data.load.shape) < 0.3
    data.slip[rests] *= 1e-3
    force[rests] *= -0.2  # static friction is whatever holds the foot
    found = fit(data, force, COULOMB, rest_m_s=1e-3)
    fast = np.linalg.norm(data.slip, axis=2) > 1e-3
    assert dict(found.result.left_out)["at rest (feet)"] == (~fast & (data.load > 0)).sum()
    assert found.mu == pytest.approx(MU)


def test_mistakes_are_refused() -> None:
    data = walk(10, frames=5)
    force = data.force(VISCOUS)
    with pytest.raises(ModelError, match="no loaded foot slips"):
        fit(data, force * np.nan, VISCOUS)
    with pytest.raises(ModelError, match="forces and slips must be"):
        fit(data, force[:, :5], VISCOUS)
    with pytest.raises(ModelError, match="frame scale only"):
        fit(data, force, COULOMB, mean_mu=1.0)
    with pytest.raises(ModelError, match="directions of w"):
        fit(data, force, VISCOUS, direction=np.zeros((6, 2)))
    with pytest.raises(ModelError, match="must not be negative"):
        fit(data, force, VISCOUS, rest_m_s=-1.0)
