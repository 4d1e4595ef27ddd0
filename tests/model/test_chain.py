"""Legs that are chains: feet and Jacobian against MuJoCo's own of random trees, and finite differences."""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.errors import ConfigError, ModelError
from model.kinematics.chain import ChainKinematics
from model.parameters.chain_table import chain_lines, read_chain
from model.parameters.tables import parse_table
from model.values.arrays import FloatArray
from model.values.parameters import ChainParameters
from record.chain_file import ChainNames, complete, read_chain_file

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    one = np.zeros(1)
    whole = np.zeros(1, dtype=np.int64)
    up = np.array([[0.0, 0, 1]])
    ChainKinematics(
        ChainParameters(("a",), whole - 1, whole > 0, up, up, one + 1, one, whole, up, one)
    ).prepare()


def example(name: str) -> ChainParameters:
    text = complete((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"), EXAMPLES)
    top = parse_table(text)
    legs = len(top.table("legs").texts("order"))
    return read_chain(top.table("leg").table("chain"), legs)


def vector(draw: st.DrawFn, size: float, length: int = 3) -> list[float]:
    return [draw(st.floats(-size, size)) for _ in range(length)]


def direction(draw: st.DrawFn, length: int) -> list[float]:
    values = np.array(vector(draw, 1.0, length))
    values[draw(st.integers(0, length - 1))] += 2.0  # never nothing
    return list(values / np.linalg.norm(values))


@st.composite
def trees(draw: st.DrawFn) -> tuple[mujoco.MjSpec, int]:
    """A body in the air with a joint that all legs share, or none, and legs of one to four links.

    A link has one or two joints, turned, shifted, hinged or sliding, at rest where the file says.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    torso = spec.worldbody.add_body(name="torso", pos=vector(draw, 1), quat=direction(draw, 4))
    torso.add_freejoint()
    torso.add_geom(size=[0.1, 0.1, 0.1])
    count = 0

    def link(parent: Any, name: str) -> Any:
        nonlocal count
        body = parent.add_body(name=name, pos=vector(draw, 0.3), quat=direction(draw, 4))
        body.add_geom(size=[0.1, 0.1, 0.1])
        for _ in range(draw(st.integers(0, 2))):
            kind = draw(st.sampled_from([mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE]))
            body.add_joint(
                name=f"joint{count}", type=kind, axis=direction(draw, 3), pos=vector(draw, 0.2),
                ref=draw(st.floats(-1, 1)),
            )  # fmt: skip
            count += 1
        return body

    root = link(torso, "waist") if draw(st.booleans()) else torso
    legs = draw(st.integers(1, 4))
    for leg in range(legs):
        tip = root
        for part in range(draw(st.integers(1, 4))):
            tip = link(tip, f"leg{leg}_{part}")
        last = tip.add_body(name=f"shank{leg}", pos=vector(draw, 0.3))
        last.add_joint(name=f"knee{leg}", axis=direction(draw, 3))
        last.add_geom(size=[0.1, 0.1, 0.1])
        last.add_site(name=f"foot{leg}", pos=vector(draw, 0.3))
    return spec, legs


def names_of(legs: int) -> ChainNames:
    feet = tuple(f"foot{leg}" for leg in range(legs))
    return ChainNames(feet, "", (), (0.0, 0.0, 0.0), tuple(f"L{leg}" for leg in range(legs)))


def by_mujoco(
    model: Any, chain: ChainParameters, feet: tuple[str, ...], angle: FloatArray, pose: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Feet, (N, 3), and Jacobian, (N, 3, J), in the frame of the body with the free joint."""
    data = mujoco.MjData(model)
    data.qpos[:7] = pose
    data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
    for name, value in zip(chain.joints, angle, strict=True):
        data.joint(name).qpos = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    body = model.jnt_bodyid[0]
    turn, place = data.xmat[body].reshape(3, 3), data.xpos[body]
    columns = [model.joint(name).dofadr[0] for name in chain.joints]
    points, slopes = [], []
    for name in feet:
        site = (
            model.site(name).id if name in [model.site(i).name for i in range(model.nsite)] else -1
        )
        slope = np.zeros((3, model.nv))
        if site >= 0:
            point = data.site_xpos[site]
            mujoco.mj_jacSite(model, data, slope, None, site)
        else:
            geom = model.geom(name)
            point = (
                data.geom_xpos[geom.id] - geom.size[0] * turn[:, 2]
            )  # below the ball, in body axes
            mujoco.mj_jac(model, data, slope, None, point, geom.bodyid[0])
        points.append(turn.T @ (point - place))
        slopes.append(turn.T @ slope[:, columns])
    return np.array(points), np.array(slopes)


@given(trees(), st.integers(0, 2**32 - 1))
def test_feet_and_jacobian_are_those_of_mujoco(tree: tuple[Any, int], seed: int) -> None:
    spec, legs = tree
    model = spec.compile()
    names = names_of(legs)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tree.xml"
        path.write_text(spec.to_xml(), encoding="utf-8")
        model = mujoco.MjModel.from_xml_path(str(path))  # what the file says, with its digits
        chain = read_chain_file(path, names)
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-3, 3, (4, chain.count))
    legs_of = ChainKinematics(chain)
    feet = legs_of.feet(angle, np.zeros_like(angle)).position_m
    slope = legs_of.jacobian(angle)
    for f in range(len(angle)):
        point, want = by_mujoco(model, chain, names.feet, angle[f], rng.uniform(-1, 1, 7))
        assert np.abs(feet[f] - point).max() < 1e-9
        assert np.abs(slope[f] - want).max() < 1e-9


@pytest.mark.parametrize("name", ["hexapod18", "quadruped12"])
def test_the_example_robots_are_those_of_mujoco(name: str) -> None:
    chain = example(name)
    model = mujoco.MjModel.from_xml_path(str(EXAMPLES / f"{name}.xml"))
    rng = np.random.default_rng(1)
    angle = rng.uniform(-1, 1, (50, chain.count))
    legs = ChainKinematics(chain)
    feet, slope = legs.feet(angle, np.zeros_like(angle)).position_m, legs.jacobian(angle)
    order = tuple(dict.fromkeys(joint.split("_")[0] for joint in chain.joints))
    for f in range(len(angle)):
        point, want = by_mujoco(
            model, chain, tuple(f"{leg}_foot" for leg in order), angle[f], rng.uniform(-1, 1, 7)
        )
        assert np.abs(feet[f] - point).max() < 1e-9
        assert np.abs(slope[f] - want).max() < 1e-9


@pytest.mark.parametrize("name", ["hexapod18", "quadruped12"])
def test_the_jacobian_is_the_derivative_of_the_feet(name: str) -> None:
    chain = replace(example(name), radius=np.zeros(len(example(name).foot)))  # points: a ball rolls
    legs, step = ChainKinematics(chain), 1e-5
    angle = np.random.default_rng(2).uniform(-1, 1, (20, chain.count))
    slope = legs.jacobian(angle)
    for joint in range(chain.count):
        by = step * np.eye(chain.count)[joint]
        ahead = legs.feet(angle + by, angle).position_m
        behind = legs.feet(angle - by, angle).position_m
        assert np.abs((ahead - behind) / (2 * step) - slope[..., joint]).max() < 1e-7


def test_a_ball_moves_on_by_its_radius_times_the_turn_of_its_link() -> None:
    chain = example("quadruped12")
    ball, point = (replace(chain, radius=np.full(4, radius)) for radius in (0.02, 0.0))
    still, knee = np.zeros(chain.count), np.eye(chain.count)[2]
    at_ball, at_point = (ChainKinematics(one).feet(still, knee) for one in (ball, point))
    assert np.allclose(at_ball.position_m - at_point.position_m, [0, 0, -0.02])
    # a turn of 1 rad/s about y drags what is below the middle back
    assert np.allclose(at_ball.velocity_m_s[0] - at_point.velocity_m_s[0], [-0.02, 0, 0])


def test_the_velocity_is_the_jacobian_times_the_speeds() -> None:
    chain = example("hexapod18")
    rng = np.random.default_rng(3)
    angle, rate = rng.uniform(-1, 1, (2, 5, 7, chain.count))
    legs = ChainKinematics(chain)
    feet = legs.feet(angle, rate)
    assert feet.position_m.shape == feet.velocity_m_s.shape == (5, 7, 6, 3)
    want = np.einsum("...njk,...k->...nj", legs.jacobian(angle), rate)
    assert np.abs(feet.velocity_m_s - want).max() < 1e-14


def test_signs_and_zeros_say_what_a_joint_of_ours_is_in_the_file() -> None:
    chain = example("quadruped12")
    rng = np.random.default_rng(4)
    sign, zero = rng.choice([-1.0, 1.0], chain.count), rng.uniform(-1, 1, chain.count)
    other = ChainParameters(
        chain.joints, chain.parent, chain.slides, chain.axis, chain.place, sign, zero,
        chain.foot_joint, chain.foot, chain.radius,
    )  # fmt: skip
    angle = rng.uniform(-1, 1, chain.count)
    here, there = ChainKinematics(other), ChainKinematics(chain)
    drawn = zero + sign * angle
    assert np.allclose(
        here.feet(angle, angle).position_m, there.feet(drawn, angle).position_m, atol=1e-15
    )
    assert np.allclose(here.jacobian(angle), sign * there.jacobian(drawn), atol=1e-15)


def test_an_unknown_joint_makes_its_own_leg_unknown_and_no_other() -> None:
    chain = example("hexapod18")
    angle = np.zeros(chain.count)
    angle[4] = np.nan  # LM_femur
    feet = ChainKinematics(chain).feet(angle, np.zeros(chain.count))
    assert np.isnan(feet.position_m[1]).any()
    assert np.isfinite(np.delete(feet.position_m, 1, axis=0)).all()
    rate = np.zeros(chain.count)
    rate[4] = np.nan
    feet = ChainKinematics(chain).feet(np.zeros(chain.count), rate)
    assert np.isfinite(feet.position_m).all()
    assert np.isnan(feet.velocity_m_s[1]).any()


def test_joints_lie_where_the_file_has_them() -> None:
    chain = example("quadruped12")
    places = ChainKinematics(chain).joint_places(np.zeros((2, chain.count)))
    assert places.shape == (2, 12, 3)
    assert np.allclose(places[0], chain.place)
    bent = np.zeros(chain.count)
    bent[1] = np.pi / 2  # LF_hip: the thigh points back
    assert np.allclose(ChainKinematics(chain).joint_places(bent)[2], [-0.02, 0.11, 0.0])


def test_values_of_other_joints_are_refused() -> None:
    legs = ChainKinematics(example("hexapod18"))
    with pytest.raises(ModelError, match="18 joints"):
        legs.jacobian(np.zeros(6))
    with pytest.raises(ModelError, match="one speed an angle"):
        legs.feet(np.zeros(18), np.zeros((2, 18)))


def test_a_table_reads_back_to_the_last_bit() -> None:
    chain = example("hexapod18")
    text = "\n".join(chain_lines(chain, 'a "model".xml'))
    again = read_chain(parse_table(text).table("leg").table("chain"), 6)
    for name in ChainParameters.__slots__:
        assert np.array_equal(getattr(again, name), getattr(chain, name)), name


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("parent = [-1, 0, 1", "parent = [1, 0, 1", "before the joint that carries it"),
        ("sign = [1,", "sign = [0,", "1 or -1"),
        ("[1.0, 0.0, 0.0],\n  [0.0, 1.0", "[2.0, 0.0, 0.0],\n  [0.0, 1.0", "length 2"),
        ("foot_joint = [2,", "foot_joint = [5,", "moves no foot"),
        ('joints = ["LF_roll"', 'joints = ["LF_hip"', "differ"),
    ],
)
def test_a_wrong_table_says_what_is_wrong(old: str, new: str, words: str) -> None:
    text = "\n".join(chain_lines(example("quadruped12"), "x"))
    assert old in text
    table = parse_table(text.replace(old, new, 1)).table("leg").table("chain")
    with pytest.raises(ConfigError, match=words):
        read_chain(table, 4)
