"""``bigant sim serve``: a virtual robot for any program that speaks to the real one.

Serve a virtual robot that any Dynamixel or WNet program can talk to, and print where to find it. Ctrl-C
ends it.
"""

import argparse
import signal
from dataclasses import replace

from robot.exit_codes import ExitCode
from robot.robot_option import add_robot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--baud", type=int, metavar="B", help="baud rate of the servos")
    parser.add_argument(
        "--absent", type=int, action="append", default=[], metavar="ID", help="a servo to leave out"
    )
    parser.add_argument("--no-force-unit", action="store_true", help="leave out the force unit")


def run(options: argparse.Namespace) -> ExitCode:
    """Serve until interrupted.

    Raises:
        ConfigError: The robot file cannot be used, or an absent servo is no servo of it.
    """
    from drivers.clock import MonotonicClock
    from model.errors import ConfigError
    from robot.config import load_robot
    from sim_hw.ati_sockets import WnetSockets
    from sim_hw.interfaces import Served
    from sim_hw.server import serve
    from sim_hw.servo_pty import PtyServoBus
    from sim_hw.virtual_robot import build_virtual_robot

    config = load_robot(options.robot)
    servo_bus = config.servo_bus
    if options.baud is not None:
        servo_bus = replace(servo_bus, baud_rate=options.baud)
    robot = build_virtual_robot(config.parameters, servo_bus, config.force_sensor, options.seed)
    for servo_id in options.absent:
        if servo_id not in servo_bus.ids:
            known = ", ".join(str(i) for i in servo_bus.ids)
            raise ConfigError("--absent", f"{servo_id} is no servo of this robot; it has {known}")
        robot.servos.silence(servo_id)
    pty = PtyServoBus(robot.servos)
    devices: list[Served] = [pty]
    print(f"servo bus   {pty.device_name}  at {servo_bus.baud_rate} baud", flush=True)
    unit = "none"
    if not options.no_force_unit:
        sockets = WnetSockets(robot.wnet)
        devices.append(sockets)
        unit = f"127.0.0.1:{sockets.udp_port}:{sockets.console_port}"
    print(f"force unit  {unit}")
    print(f"try: bigant drive --hardware {pty.device_name} --force-unit {unit} --armed", flush=True)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        serve(robot, devices, MonotonicClock(), truth=None, control=None)
    except KeyboardInterrupt:
        print("stopped")
    finally:
        for device in devices:
            device.close()
    return ExitCode.OK
