"""The robot file's parameters as URDF and as MJCF, by element trees.

Axes as everywhere: x forward, y left, z up. A positive turn about +y takes x towards -z: so a crank joint
about +y whose frame is turned by minus the mid-stance direction has the shaft angle as its value.
"""

from xml.etree.ElementTree import Element, indent, tostring

import mujoco
import numpy as np

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106
from drivers.dynamixel.servo_model import ServoModel
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import CrankParameters, FourBarParameters, RobotParameters
from record.whole_file import write_text
from robot.config import crank_xml, four_bar_xml
from robot.config.robot_file import load_robot
from robot.config.xml_elements import LINK_MASS, add, urdf_link
from robot.console.exit_codes import ExitCode
from robot.requests.robot import RobotExportRequest

TORSO_HALF_HEIGHT = 0.03
POSITION_GAIN = 55.0  # N m/rad: the MX-106's own gain at 12 V
GAIN_REGISTER = "position_p_gain"


def export(request: RobotExportRequest) -> ExitCode:
    """Write a robot file as URDF, as MJCF or both, and check that MuJoCo loads them.

    Raises:
        ConfigError: Nothing is asked for.
        RecordError: A file cannot be written.
    """
    if request.urdf is None and request.mjcf is None:
        raise ConfigError("--urdf, --mjcf", "nothing to write: give --urdf OUT, --mjcf OUT or both")
    config = load_robot(request.robot)
    wanted = (("--urdf", request.urdf, urdf_text), ("--mjcf", request.mjcf, mjcf_text))
    for option, path, make in wanted:
        if path is None:
            continue
        text = make(config.name, config.parameters)
        model = mujoco.MjModel.from_xml_string(text)
        write_text(path, text, option)
        mass = float(model.body_mass.sum())
        print(f"{path}: {model.njnt} joints, {mass:.3f} kg; MuJoCo loads it")
    return ExitCode.OK


def position_gain(model: ServoModel, supply_v: float) -> float:
    """Return a servo's own gain from the factory [N m/rad]: the MX-106's in proportion.

    To its P gain, and to its stall torque at the supply voltage by the data sheet.
    """
    share = (model.table[GAIN_REGISTER].initial or 0) / (MX_106.table[GAIN_REGISTER].initial or 1)
    torque = model.ratings.stall_torque_n_m / MX_106.ratings.stall_torque_n_m
    return POSITION_GAIN * share * torque * (supply_v / model.ratings.voltage_v)


def urdf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as URDF."""
    top = Element("robot", name=name)
    # MuJoCo merges a root without joint into the world by default
    add(add(top, "mujoco"), "compiler", fusestatic="false", balanceinertia="true")
    legs, geometry = robot.legs, robot.leg
    base = urdf_link(top, "base_link", _torso_mass(robot), robot.body.inertia)
    half = _half_sizes(robot)
    box = add(add(base, "visual"), "geometry")
    add(box, "box", size=[2 * half[0], 1.6 * half[1], 2 * TORSO_HALF_HEIGHT])
    for leg, place in zip(legs.names, legs.shaft_position, strict=True):
        match geometry:
            case FourBarParameters():
                four_bar_xml.urdf_four_bar(top, geometry, leg, place)
            case CrankParameters():
                crank_xml.urdf_crank(top, geometry, leg, place)
    indent(top)
    return '<?xml version="1.0"?>\n' + tostring(top, encoding="unicode") + "\n"


def _torso_mass(robot: RobotParameters) -> float:
    match robot.leg:
        case FourBarParameters():
            links = four_bar_xml.LINKS
        case CrankParameters():
            links = crank_xml.LINKS
    return robot.body.mass - links * LINK_MASS * robot.legs.count


def _half_sizes(robot: RobotParameters) -> FloatArray:
    half: FloatArray = np.abs(robot.legs.shaft_position[:, :2]).max(axis=0)
    return half


def mjcf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as a MuJoCo model: legs that turn, closed where they are loops, motors, ground."""
    top = Element("mujoco", model=name)
    add(top, "option", timestep=0.0005, integrator="implicitfast", cone="elliptic", impratio=20)
    world = add(top, "worldbody")
    add(world, "geom", name="ground", type="plane", size="0 0 1", friction="1e-6 0 0")
    torso = add(world, "body", name="torso", pos="0 0 0.14")
    add(torso, "freejoint", name="free")
    add(torso, "inertial", pos="0 0 0", mass=_torso_mass(robot), diaginertia=robot.body.inertia)
    half = _half_sizes(robot)
    size = [half[0], 0.8 * half[1], TORSO_HALF_HEIGHT]
    add(torso, "geom", type="box", size=size, mass=0, contype=0, conaffinity=1)
    equality, actuator = add(top, "equality"), add(top, "actuator")
    legs, geometry = robot.legs, robot.leg
    each = zip(legs.names, legs.shaft_position, robot.contact.mu, robot.servo.models, strict=True)
    for leg, place, mu, servo in each:
        gain = position_gain(MODEL_BY_NAME[servo], robot.servo.supply_voltage)
        match geometry:
            case FourBarParameters():
                four_bar_xml.mjcf_four_bar(torso, equality, geometry, leg, place, mu)
            case CrankParameters():
                crank_xml.mjcf_crank(torso, geometry, leg, place, mu)
        add(actuator, "position", name=f"{leg}_shaft", joint=f"{leg}_shaft", kp=gain)
    indent(top)
    return tostring(top, encoding="unicode") + "\n"
