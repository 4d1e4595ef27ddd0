"""Legs from MJCF and URDF files: what of a file is read, what it may lack, and what is refused in words."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError
from model.kinematics.chain import ChainKinematics
from model.parameters.chain_table import read_chain
from model.parameters.tables import parse_table
from model.values.parameters import ChainParameters
from record.chain_file import ChainNames, complete, read_chain_file

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"

URDF = """<robot name="one">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://not/there.dae"/></geometry></visual>
  </link>
  <link name="thigh"><collision><geometry><mesh filename="nor_this.stl"/></geometry></collision></link>
  <link name="toe"/>
  <joint name="hip" type="revolute">
    <parent link="base"/><child link="thigh"/><origin xyz="0.1 0.2 0" rpy="0 0.5 0"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="end" type="fixed">
    <parent link="thigh"/><child link="toe"/><origin xyz="0 0 -0.3"/>
  </joint>
</robot>"""
MJCF = """<mujoco><compiler angle="radian"/>
  <asset><mesh name="shell" file="not_there.stl"/></asset>
  <worldbody>
    <body name="torso"><freejoint/><geom type="mesh" mesh="shell"/>
      <body name="arm" pos="0.1 0 0"><joint name="first" axis="0 1 0" ref="0.3"/>
        <geom type="mesh" mesh="shell"/><geom name="tip" size="0.01" pos="0 0 -0.2"/>
        <body name="hand" pos="0 0 -0.1"><joint name="ball" type="ball"/><geom size="0.01"/></body>
      </body>
    </body>
    <body name="apart"><geom size="0.1"/></body>
  </worldbody>
  <actuator><motor joint="first"/></actuator>
  <keyframe><key qpos="0 0 0 1 0 0 0 0.5 1 0 0 0"/></keyframe>
</mujoco>"""


def named(*feet: str, body: str = "", joints: tuple[str, ...] = ()) -> ChainNames:
    return ChainNames(feet, body, joints, (0.0, 0.0, 0.0), tuple(f"L{i}" for i in range(len(feet))))


def read(tmp_path: Path, text: str, names: ChainNames) -> ChainParameters:
    path = tmp_path / "robot.xml"
    path.write_text(text, encoding="utf-8")
    return read_chain_file(path, names)


def test_a_urdf_with_fixed_links_and_without_its_meshes_is_read(tmp_path: Path) -> None:
    chain = read(tmp_path, URDF, named("toe"))
    assert chain.joints == ("hip",)
    s, c = np.sin(0.5), np.cos(0.5)
    feet = ChainKinematics(chain).feet(np.zeros(1), np.ones(1))
    assert np.allclose(feet.position_m, [[0.1 - 0.3 * s, 0.2, -0.3 * c]])
    assert np.allclose(feet.velocity_m_s, [[-0.3 * c, 0, 0.3 * s]])


def test_a_joint_counts_from_where_the_file_says(tmp_path: Path) -> None:
    legs = ChainKinematics(read(tmp_path, MJCF, named("tip")))
    assert np.allclose(legs.feet(np.array([0.3]), np.zeros(1)).position_m, [[0.1, 0, -0.21]])
    turned = legs.feet(np.array([0.3 + np.pi / 2]), np.zeros(1)).position_m
    assert np.allclose(turned, [[-0.1, 0, -0.01]])


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (named("toe"), "leg.feet: .* has no site, geom or body 'toe'"),
        (named("tip", body="trunk"), "leg.body: .* has no body 'trunk'; there are torso"),
        (named("apart"), "leg.feet: apart does not hang on torso"),
        (named("torso"), "leg.feet: no joint is between torso and torso"),
        (named("hand"), "leg.model: joint 'ball' of leg L0 neither turns"),
        (named("tip", joints=("second",)), "leg.joints: 'second' moves no foot; .* are first"),
        (ChainNames(("tip",), "", (), (0, 0, 0), ("A", "B")), "leg.feet: names 1 feet for 2 legs"),
    ],
)
def test_what_a_file_lacks_is_named(tmp_path: Path, names: ChainNames, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        read(tmp_path, MJCF, names)


def test_a_body_has_to_be_named_where_there_are_several(tmp_path: Path) -> None:
    text = MJCF.replace("<freejoint/>", "")
    with pytest.raises(ConfigError, match=r"leg\.body: is missing, and .* has 2 bodies"):
        read(tmp_path, text, named("tip"))
    assert read(tmp_path, text, named("tip", body="torso")).joints == ("first",)


def test_a_file_that_is_none_or_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"leg\.model: .* is no MJCF or URDF for MuJoCo"):
        read(tmp_path, "no xml", named("tip"))
    with pytest.raises(ConfigError, match=r"leg\.model: .* cannot be read: No such file"):
        read_chain_file(tmp_path / "away.xml", named("tip"))


def test_a_robot_file_is_complete_once(tmp_path: Path) -> None:
    text = (EXAMPLES / "hexapod18.toml").read_text(encoding="utf-8")
    whole = complete(text, EXAMPLES)
    assert whole.startswith(text)
    assert complete(whole, tmp_path) == whole  # the model file is not looked for again
    four_bar = (ROOT / "config" / "bigant.toml").read_text(encoding="utf-8")
    assert complete(four_bar, tmp_path) is four_bar


def test_names_order_signs_and_zeros_of_a_robot_file_hold(tmp_path: Path) -> None:
    text = (EXAMPLES / "quadruped12.toml").read_text(encoding="utf-8")
    joints = [
        f"{leg}_{part}" for part in ("roll", "hip", "knee") for leg in ("LF", "RF", "LH", "RH")
    ]
    own = (
        f"joints = {joints!r}\nsign = {[-1, *[1] * 11]}\nzero = {[0.25, *[0.0] * 11]}\n"
        'body = "trunk"\norigin = [0.01, 0.0, 0.0]\n[contact]'
    )
    whole = complete(text.replace("[contact]", own), EXAMPLES)
    chain = read_chain(parse_table(whole).table("leg").table("chain"), 4)
    assert chain.joints == tuple(joints)
    assert [[chain.joints[row] for row in chain.joints_of(leg)] for leg in (0, 3)] == [
        ["LF_roll", "LF_hip", "LF_knee"],
        ["RH_roll", "RH_hip", "RH_knee"],
    ]
    assert (chain.sign[0], chain.zero[0]) == (-1, 0.25)
    assert np.allclose(chain.foot[0], [0.17, 0.11, -0.4])


def test_joints_before_those_that_carry_them_are_refused() -> None:
    text = (EXAMPLES / "quadruped12.toml").read_text(encoding="utf-8")
    joints = [
        f"{leg}_{part}" for leg in ("LF", "RF", "LH", "RH") for part in ("hip", "roll", "knee")
    ]
    with pytest.raises(
        ConfigError, match=r"leg\.joints: LF_hip comes before the joint that carries"
    ):
        complete(text.replace("[contact]", f"joints = {joints!r}\n[contact]"), EXAMPLES)
    few = text.replace("[contact]", 'joints = ["LF_roll"]\n[contact]')
    with pytest.raises(ConfigError, match=r"leg\.joints: is without LF_hip, LF_knee, LH_hip"):
        complete(few, EXAMPLES)


def test_an_inline_table_says_how_to_write_it() -> None:
    text = (EXAMPLES / "quadruped12.toml").read_text(encoding="utf-8")
    body = re.search(r"\[leg\]\n(.*?)\n\n", text, re.DOTALL)
    assert body is not None
    lines = body[1].splitlines()
    inline = "leg = { " + ", ".join(line.split("  #")[0] for line in lines) + " }\n"
    with pytest.raises(ConfigError, match=r"leg: write it as a table of its own"):
        complete(inline + text.replace(body[0], ""), EXAMPLES)


def test_a_robot_of_four_bars_loads_no_simulator() -> None:
    code = (
        "import sys; from robot.config.robot_file import load_robot; load_robot();"
        "print('mujoco' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"
