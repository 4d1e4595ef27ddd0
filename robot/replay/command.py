"""What ``bigant replay`` does: through the step, through the drivers, or on a robot again."""

import json
from dataclasses import asdict

from model.errors import ConfigError
from record.log.reader import LogContents
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.plain_json import plain
from robot.console.progress import ProgressLine
from robot.control.effect_uses import say_unused
from robot.replay.bus import BusReplay, replay_bus
from robot.replay.request import ReplayRequest
from robot.replay.text import bus_lines, replay_lines
from robot.replay.ticks import Replay, replay_log


def replay(request: ReplayRequest) -> ExitCode:
    """Replay a log, print the result.

    Raises:
        BigantError: The log cannot be read or replayed.
    """
    if request.drive:
        from robot.replay.drive import drive_again  # pictures take their time to load

        return drive_again(request)
    for name in ("armed", "virtual_time", "log", "out"):
        if getattr(request, name):
            raise ConfigError(f"--{name.replace('_', '-')}", "goes with --drive only")
    config = None if request.robot is None else load_robot(request.robot)
    if config is not None:
        say_unused(config)
    contents = LogContents()
    result: BusReplay | Replay
    with ProgressLine(f"replaying {request.path}", contents.progress):
        method = replay_bus if request.bus else replay_log
        result = method(request.path, scale=request.tolerance, config=config, contents=contents)
    if request.json:
        print(json.dumps(plain({**asdict(result), "equal": result.equal}), indent=2))
    else:
        lines = bus_lines(result) if isinstance(result, BusReplay) else replay_lines(result)
        print("\n".join(lines))
    return ExitCode.OK if result.equal else ExitCode.VERDICT_FAILED
