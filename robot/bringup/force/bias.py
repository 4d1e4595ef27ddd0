"""``bigant force bias``: the mean of the force sensors of a robot that touches nothing."""

import time
from pathlib import Path

import numpy as np

from drivers.ati.foot_forces import sensed_wrenches
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import Clock, MonotonicClock
from model.errors import ModelError
from model.fit.force_bias import Bias, measure_bias, require_rest
from model.values.arrays import FloatArray
from model.values.force_calibration import AXES, CalibrationOrigin, bias_only
from model.values.gravity import STANDARD_GRAVITY
from robot.config.calibration import write_calibration
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.program_output import complain
from robot.console.progress import StatusLine
from robot.console.table import Column, table_lines
from robot.requests.force import ForceBiasRequest
from robot.run.force_unit import running_stream, unit_settings
from robot.run.operator import Interrupts

LOOK_NS = 10_000_000
STANDING_SHARE = 0.5  # of the weight; transducers unloaded are seldom off by that much together


def measure(request: ForceBiasRequest) -> ExitCode:
    """Measure, judge, write.

    Raises:
        ModelError: The sensors were not at rest.
        BigantError: The unit cannot be reached, or a file cannot be used.
    """
    config = load_robot(request.robot)
    settings = unit_settings(request.force_unit, config.force_sensor)
    names, clock = settings.names, MonotonicClock()
    with Interrupts() as interrupts, running_stream(settings, clock) as stream:
        interrupts.begin()
        serials = tuple("" if c is None else c.serial for c in stream.calibrations)
        if request.device_off:
            stream.set_device_bias(on=False)
        for with_device_bias in (False, True) if request.device else (False,):
            if with_device_bias:
                stream.set_device_bias(on=True)
            bias = measure_bias(_collect(stream, settings, clock, interrupts, request.seconds))
            require_rest(bias, names)
    date = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    calibration = bias_only(names, CalibrationOrigin(serials, date), bias.mean, bias.standard_error)
    for line in standing_warnings(bias.mean, config.parameters.body.mass):
        complain(f"warning: {line}")
    write_calibration(request.out, calibration)
    kept = f"calibration: {request.out}   (bigant drive --calibration {request.out})"
    print_result(
        _as_json(bias, names, request.out), [*_lines(bias, names), kept], as_json=request.json
    )
    return ExitCode.OK


def _as_json(bias: Bias, names: tuple[str, ...], out: Path) -> object:
    legs = [
        {"leg": name, "samples": samples, "bias": mean, "standard_error": error}
        for name, samples, mean, error in zip(
            names, bias.samples, bias.mean, bias.standard_error, strict=True
        )
    ]
    return {"axes": AXES, "legs": legs, "file": out}


def _lines(bias: Bias, names: tuple[str, ...]) -> list[str]:
    columns = (Column("leg"), Column("samples", "d"), *(Column(axis) for axis in AXES))
    rows = []
    for leg, name in enumerate(names):
        pairs = zip(bias.mean[leg], bias.standard_error[leg], strict=True)
        cells = [f"{m:9.4f} +- {e:.4f}" if bias.known[leg] else "no bias" for m, e in pairs]
        rows.append((name, int(bias.samples[leg]), *cells))
    return ["bias and standard error, N and N m", *table_lines(columns, rows)]


def standing_warnings(mean: FloatArray, mass_kg: float) -> tuple[str, ...]:
    """Warn if the readings look as if the feet carried the robot: a standing robot is at rest, too.

    Args:
        mean: Mean readings, sensor axes, (N, 6) [N, N m]; NaN where there were none.
        mass_kg: Of the robot.
    """
    total_n, weight_n = float(np.nansum(mean[:, 2])), mass_kg * STANDARD_GRAVITY
    if abs(total_n) < STANDING_SHARE * weight_n:
        return ()
    return (
        f"together the sensors read {total_n:.0f} N along z, and the robot weighs {weight_n:.0f} N: "
        "does it stand? Hang it up, no foot on the ground, and measure again",
    )


def _collect(
    stream: ForceStream,
    settings: ForceSensorSettings,
    clock: Clock,
    interrupts: Interrupts,
    seconds: float,
) -> FloatArray:
    """Return what the sensors read for some seconds, (T, N, 6), nothing subtracted."""
    stream.read()  # what came before does not count
    begin_ns = clock.now_ns()
    rows: list[FloatArray] = []
    with StatusLine() as status:
        while (done_s := (clock.now_ns() - begin_ns) * 1e-9) < seconds:
            clock.sleep_until_ns(clock.now_ns() + LOOK_NS)
            rows += [sensed_wrenches(r, stream.calibrations, settings) for r in stream.read()]
            if interrupts.count:
                raise ModelError("interrupted; nothing was written")
            status.step(f"measuring {done_s:.0f} of {seconds:.0f} s")
    return np.array(rows).reshape(-1, len(settings.names), 6)
