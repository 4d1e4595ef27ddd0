"""A first start makes machine code before the devices answer, and never while a servo is asked."""

import subprocess
import sys
from pathlib import Path

import pytest

from model.compiled import compiles
from tests.soaked import THOROUGH

ROOT = Path(__file__).resolve().parents[2]
# In a fresh interpreter with an empty cache: what is compiled once the virtual robot is built?
FIRST_USE = """
import sys
from numba.core import event

class Tell(event.Listener):
    def on_start(self, event):
        print("compiles", event.data["dispatcher"].py_func.__qualname__, flush=True)

    def on_end(self, event):
        pass

event.register("numba:compile", Tell())
from drivers.dynamixel.frames import Instruction, build_instruction
from robot.config.robot_file import load_robot
from sim_hw.host.virtual_robot import build_virtual_robot
from tests.sim_hw.twins import twin

config = load_robot()
robot = build_virtual_robot(
    config.parameters, config.servo_bus, config.force_sensor, 0, twin(*sys.argv[1:]),
)
print("ready", flush=True)

wire, world, t_ns = robot.servo_wire, robot.world, 0
def ask(instruction, parameters):
    global t_ns
    t_ns += 1_000_000
    wire.receive(build_instruction(1, instruction, parameters), t_ns, config.servo_bus.baud_rate)
    t_ns += 9_000_000
    wire.poll(t_ns)
    return wire.replies(t_ns)

world.advance_to(0)
assert ask(Instruction.PING, b"")
assert ask(Instruction.WRITE, bytes([64, 0, 1]))  # torque on
assert ask(Instruction.WRITE, bytes([116, 0, 0, 9, 0, 0]))  # a goal
assert len(ask(Instruction.READ, bytes([132, 0, 4, 0]))) == 15
world.wrench(t_ns)
world.truth(t_ns + 50_000_000)
print("used")
"""
EFFECTS = (
    "gear_backlash@ML", "command_delay", "stiction", "friction_anisotropy", "foot_rolling",
)  # fmt: skip


@pytest.mark.skipif(not compiles(), reason="numba is not there")
@pytest.mark.parametrize(
    "effects",
    [
        pytest.param((), id="", marks=pytest.mark.soak),
        pytest.param(EFFECTS, id=" ".join(EFFECTS), marks=THOROUGH),
    ],
)
def test_nothing_is_compiled_once_the_virtual_robot_answers(
    tmp_path: Path, effects: tuple[str, ...]
) -> None:
    told = subprocess.run(
        [sys.executable, "-c", FIRST_USE, *effects],
        cwd=ROOT,
        env={"NUMBA_CACHE_DIR": str(tmp_path), "PATH": "", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    assert any(line.startswith("compiles") for line in told[: told.index("ready")])
    assert told[told.index("ready") :] == ["ready", "used"]
