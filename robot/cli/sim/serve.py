"""``bigant sim serve``: virtual devices on a pseudo-terminal and loopback sockets until Ctrl-C.

Serve a virtual robot that any Dynamixel or WNet program can talk to, and print where to find it. Ctrl-C
ends it.
"""

import argparse
import signal
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from robot.bringup.servo.access import baud_rate
from robot.console.arguments import add_robot, add_scenario, seed
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from sim_hw.faults.scenario import Scenario
    from sim_hw.host.virtual_robot import VirtualRobot
    from sim_hw.interfaces import Served


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate of the servos")
    parser.add_argument(
        "--absent", type=int, action="append", default=[], metavar="ID", help="a servo to leave out"
    )
    parser.add_argument("--no-force-unit", action="store_true", help="leave out the force unit")
    add_scenario(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Serve until interrupted.

    Raises:
        ConfigError: The robot file cannot be used, or an absent servo is no servo of it.
    """
    from model.errors import ConfigError
    from robot.config.robot_file import load_robot
    from robot.virtual.file_twin import file_twin
    from sim_hw.faults.scenario import load_scenario
    from sim_hw.host.virtual_robot import build_virtual_robot

    config = load_robot(options.robot)
    servo_bus = config.servo_bus
    if options.baud is not None:
        servo_bus = replace(servo_bus, baud_rate=options.baud)
    scenario = None
    if options.scenario is not None:
        scenario = load_scenario(options.scenario, [int(i) for i in servo_bus.ids])
    robot = build_virtual_robot(
        config.parameters, servo_bus, config.force_sensor, options.seed,
        twin=file_twin(config, options.seed), scenario=scenario,
    )  # fmt: skip
    for servo_id in options.absent:
        if servo_id not in servo_bus.ids:
            known = ", ".join(str(i) for i in servo_bus.ids)
            raise ConfigError("--absent", f"{servo_id} is no servo of this robot; it has {known}")
        robot.servos.silence(servo_id)
    with ExitStack() as stack:
        try:
            _serve(robot, scenario, servo_bus.baud_rate, stack, with_wnet=not options.no_force_unit)
        except KeyboardInterrupt:
            print("stopped")
    return ExitCode.OK


def _serve(
    robot: "VirtualRobot",
    scenario: "Scenario | None",
    baud_rate: int,
    stack: ExitStack,
    *,
    with_wnet: bool,
) -> None:
    from drivers.clock import MonotonicClock
    from sim_hw.ati.sockets import WnetSockets
    from sim_hw.host.server import open_servo_pty, serve

    for number in (signal.SIGINT, signal.SIGTERM):  # a shell's background jobs ignore SIGINT
        signal.signal(number, signal.default_int_handler)
    pty = open_servo_pty(robot, scenario, stack)
    devices: list[Served] = [pty]
    print(f"servo bus   {pty.device_name}  at {baud_rate} baud", flush=True)
    unit = "none"
    if with_wnet:
        sockets = WnetSockets(robot.wnet_wire)
        stack.callback(sockets.close)
        devices.append(sockets)
        unit = f"127.0.0.1:{sockets.udp_port}:{sockets.console_port}"
    print(f"force unit  {unit}")
    print(f"try: bigant drive --hardware {pty.device_name} --force-unit {unit} --armed", flush=True)
    serve(robot, devices, MonotonicClock(), truth=None, control=None)
