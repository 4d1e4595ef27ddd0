"""``bigant sim serve``: a virtual robot on a pseudo-terminal and loopback sockets, for any program."""

import signal
import sys
from contextlib import ExitStack
from dataclasses import replace

from drivers.clock import MonotonicClock
from model.errors import ConfigError
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.design.review import print_warnings, review_for_run
from robot.requests.sim import SimServeRequest
from robot.virtual.file_twin import file_twin
from robot.virtual.open import VirtualSettings, imu_setup
from sim_hw.ati.sockets import WnetSockets
from sim_hw.faults.scenario import Scenario, load_scenario
from sim_hw.host.server import open_imu_pty, open_servo_pty, serve
from sim_hw.host.virtual_robot import VirtualRobot, build_virtual_robot
from sim_hw.interfaces import Served


def serve_robot(request: SimServeRequest) -> ExitCode:
    """Serve until interrupted.

    Raises:
        ConfigError: The robot file cannot be used, or an absent servo is no servo of it.
    """
    config = load_robot(request.robot)
    bus = config.servo_bus
    if request.baud is not None:
        bus = replace(bus, baud_rate=request.baud)
    scenario = None
    if request.scenario is not None:
        scenario = load_scenario(request.scenario, [int(i) for i in bus.ids])
    robot = build_virtual_robot(
        config.parameters, bus, config.force_sensor, request.seed,
        twin=file_twin(config, request.seed), scenario=scenario,
        imu=imu_setup(config, VirtualSettings(seed=request.seed, scenario=scenario)),
    )  # fmt: skip
    for servo_id in request.absent:
        if servo_id not in bus.ids:
            known = ", ".join(str(i) for i in bus.ids)
            raise ConfigError("--absent", f"{servo_id} is no servo of this robot; it has {known}")
        robot.servos.silence(servo_id)
    print_warnings(review_for_run(config))
    with_unit = config.force_sensor.any and not request.no_force_unit
    with ExitStack() as stack:
        try:
            _serve(robot, scenario, bus.baud_rate, stack, with_wnet=with_unit)
        except KeyboardInterrupt:
            print("stopped")
    return ExitCode.OK


def _serve(
    robot: VirtualRobot,
    scenario: Scenario | None,
    baud_rate: int,
    stack: ExitStack,
    *,
    with_wnet: bool,
) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell's background jobs ignore SIGINT
        signal.signal(number, signal.default_int_handler)
    pty = open_servo_pty(
        robot, scenario, stack, lambda words: print(words, file=sys.stderr, flush=True)
    )
    devices: list[Served] = [pty]
    print(f"servo bus   {pty.device_name}  at {baud_rate} baud", flush=True)
    unit = "none"
    if with_wnet:
        sockets = WnetSockets(robot.wnet_wire)
        stack.callback(sockets.close)
        devices.append(sockets)
        unit = f"127.0.0.1:{sockets.udp_port}:{sockets.console_port}"
    print(f"force unit  {unit}")
    clock = MonotonicClock()
    imu, with_imu = open_imu_pty(robot, clock, stack), ""
    if imu is not None:
        devices.append(imu)
        print(f"imu         {imu.device_name}")
        with_imu = f" --imu {imu.device_name}"
    print(
        f"try: bigant drive --hardware {pty.device_name} --force-unit {unit}{with_imu} --armed",
        flush=True,
    )
    serve(robot, devices, clock, truth=None, control=None)
