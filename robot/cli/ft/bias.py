"""``bigant ft bias``: what the sensors read with no contact, measured on the host.

Hang the robot up so that no foot touches anything. The mean over some seconds goes into a calibration
file, with its standard error; the unit itself is not changed unless --device is given. Refused when the
readings spread or wander as they do when something touches the robot.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import ConfigError, ModelError
from robot.console.exit_codes import ExitCode
from robot.console.plain_json import plain

if TYPE_CHECKING:
    from drivers.ati.stream import ForceStream
    from drivers.clock import Clock
    from drivers.settings import ForceSensorSettings
    from model.values.arrays import FloatArray
    from robot.run.operator import Interrupts

LOOK_NS = 10_000_000
LEAST_SECONDS = 1.0
STANDING_SHARE = 0.5  # of the weight; transducers unloaded are seldom off by that much together


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("--robot", type=Path, metavar="FILE", help="robot file")
    parser.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]", help="(default: robot file)")
    parser.add_argument("--seconds", type=float, default=5.0, metavar="S", help="(default: 5)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("force-bias.toml"),
        metavar="FILE",
        help="calibration file to write (default: force-bias.toml)",
    )
    parser.add_argument(
        "--device", action="store_true",
        help="also switch the unit's own BIAS on for every transducer (it then counts from zero, so "
        "the file written beside it holds zeros measured after that)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Measure, judge, write.

    Raises:
        ModelError: The sensors were not at rest.
        BigantError: The unit cannot be reached, or a file cannot be used.
    """
    from drivers.clock import MonotonicClock
    from model.fit.force_bias import measure_bias, require_rest
    from model.values.force_calibration import AXES, bias_only
    from robot.config.calibration import write_calibration
    from robot.config.robot_file import DEFAULT_ROBOT_FILE, load_robot
    from robot.console.earlier_file import keep_earlier
    from robot.run.force_unit import running_stream, unit_settings
    from robot.run.operator import Interrupts

    if not LEAST_SECONDS <= options.seconds <= 3600:
        raise ConfigError("--seconds", f"must be from 1 to 3600, not {options.seconds:g}")
    config = load_robot(options.robot or DEFAULT_ROBOT_FILE)
    settings = unit_settings(options.force_unit, config.force_sensor)
    names = settings.names
    clock = MonotonicClock()
    with Interrupts() as interrupts, running_stream(settings, clock) as stream:
        serials = tuple("" if c is None else c.serial for c in stream.calibrations)
        bias = measure_bias(_collect(stream, settings, clock, interrupts, options.seconds))
        require_rest(bias, names)
        if options.device:
            stream.set_device_bias()
            bias = measure_bias(_collect(stream, settings, clock, interrupts, options.seconds))
            require_rest(bias, names)
    calibration = bias_only(
        names,
        serials,
        bias.mean,
        bias.standard_error,
        date=time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        logs=(),
    )
    for line in standing_warnings(bias.mean, config.parameters.body.mass):
        print(f"warning: {line}", file=sys.stderr)
    keep_earlier(options.out)
    write_calibration(options.out, calibration)
    if options.json:
        legs = [
            {
                "leg": name,
                "samples": int(bias.samples[leg]),
                "bias": bias.mean[leg].tolist(),
                "standard_error": bias.standard_error[leg].tolist(),
            }
            for leg, name in enumerate(names)
        ]
        print(json.dumps(plain({"axes": list(AXES), "legs": legs, "file": options.out}), indent=2))
        return ExitCode.OK
    print("bias and standard error, N and N m")
    print("leg   samples" + "".join(f"{axis:>20}" for axis in AXES))
    for leg, name in enumerate(names):
        pairs = zip(bias.mean[leg], bias.standard_error[leg], strict=True)
        cells = "".join(f"{f'{m:.4f} +- {e:.4f}':>20}" for m, e in pairs)
        print(f"{name:<5} {bias.samples[leg]:>7}" + (cells if bias.known[leg] else "  no bias"))
    print(f"calibration: {options.out}   (bigant drive --calibration {options.out})")
    return ExitCode.OK


def standing_warnings(mean: "FloatArray", mass_kg: float) -> tuple[str, ...]:
    """Say if the readings look as if the feet carried the robot; steady is what standing is, too.

    Args:
        mean: Mean readings, sensor axes, (N, 6) [N, N m]; NaN where there were none.
        mass_kg: Of the robot.
    """
    import numpy as np
    from scipy.constants import g as standard_gravity

    total_n, weight_n = float(np.nansum(mean[:, 2])), mass_kg * standard_gravity
    if abs(total_n) < STANDING_SHARE * weight_n:
        return ()
    return (
        f"together the sensors read {total_n:.0f} N along z, and the robot weighs {weight_n:.0f} N: "
        "does it stand? Hang it up, no foot on the ground, and measure again",
    )


def _collect(
    stream: "ForceStream",
    settings: "ForceSensorSettings",
    clock: "Clock",
    interrupts: "Interrupts",
    seconds: float,
) -> "FloatArray":
    """Return what the sensors read for some seconds, (T, N, 6), nothing taken off."""
    import numpy as np

    from drivers.ati.foot_forces import sensed_wrenches

    stream.read()  # what came before does not count
    begin_ns = clock.now_ns()
    rows: list[FloatArray] = []
    while (done_s := (clock.now_ns() - begin_ns) * 1e-9) < seconds:
        clock.sleep_until_ns(clock.now_ns() + LOOK_NS)
        rows += [sensed_wrenches(r, stream.calibrations, settings) for r in stream.read()]
        if interrupts.count:
            raise ModelError("interrupted; nothing was written")
        if sys.stderr.isatty():
            print(f"\rmeasuring {done_s:.0f} of {seconds:.0f} s", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print("\r" + " " * 40 + "\r", end="", file=sys.stderr)
    return np.array(rows).reshape(-1, len(settings.names), 6)
