"""Golden logs: short runs of the virtual robot in virtual time, and what today's code makes of them.

``make golden`` (``python -m tests.replay.golden``) writes the change indicators anew: per golden log one
CSV of nine digits with today's outputs, in metres and newtons, for a person who reads the difference in
a review. A log whose recorded outputs are no longer today's gets today's outputs; its inputs stay.
``--record`` runs the virtual robot again, which changes the inputs too.

To stay small a golden log runs at a tenth of the robot's rate and leaves out what the step does not use:
the truth, and all force records of a tick but its last.
"""

import argparse
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from drivers.ati.calibration import Calibration
from model.values.faults import StopReason
from model.values.tick import Intent, Request, Tick
from record.log.definitions import DEFINITIONS
from record.log.reader import LogContents, read_tick_messages
from record.log.tick_message import encode_tick
from record.log.writer import (
    CONFIG_NAME,
    LIBRARY,
    METADATA_NAME,
    NAMES_KEY,
    START_KEY,
)
from record.topics import TICK_TOPIC
from robot.config.robot_file import load_robot
from robot.control.controller import Controller
from robot.replay.step_through import step_through
from robot.replay.ticks import replay_log
from robot.run.header import controller_metadata
from robot.run.loop import run
from robot.run.rebuilt import rebuild_controller
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory
from tests.robot.runs import Kept, Told, wish

FOLDER = Path(__file__).resolve().parent / "golden"
NAMES = ("tripod", "metachronal", "faults")
RATE_HZ = 10
TICKS = 90
SEED = 3
DIGITS = 9
# What lies below this is rounding: a nanometre, a nanonewton.
DECIMALS = 9
Disturb = Callable[[Rig, Tick], None]


def log_of(name: str) -> Path:
    return FOLDER / f"{name}.mcap"


def csv_of(name: str) -> Path:
    return FOLDER / f"{name}.csv"


# Recording.


def _calm(_rig: Rig, _tick: Tick) -> None:
    pass


def _faulty(rig: Rig, tick: Tick) -> None:
    """A reading lost now and then, a damaged reply, at last a hot servo."""
    servos: Any = rig.bus._port._bus
    servos.silence(2, on=tick.index % 20 == 10)
    if tick.index == 35:
        servos.damage_next_reply()
    if tick.index > 70:
        servos._world.plant.temperature_c[1] = 76.0


def walk(gait: str, frequency_hz: float, steer: float = 0.0) -> Callable[[], Told]:
    return lambda: Told(lambda _t, _tick: wish(Intent.WALK, gait, frequency_hz, steer))


RECIPES: dict[str, tuple[Callable[[], Told], Disturb]] = {
    "tripod": (walk("tripod", 0.25), _calm),
    "metachronal": (walk("metachronal", 0.1, 0.5), _calm),
    "faults": (walk("tripod", 0.25), _faulty),
}


def record(name: str) -> None:
    operator, disturb = RECIPES[name]
    config = load_robot()
    rig = open_in_memory(config, VirtualSettings(seed=SEED))
    controller = Controller(config, rig.calibrations, armed=True, rate_hz=RATE_HZ)

    class Disturber:
        def show(self, tick: Tick) -> None:
            disturb(rig, tick)

    kept = Kept()
    run(rig, controller, Until(operator(), TICKS), kept, Disturber())
    write(log_of(name), map(_lean, kept.ticks[:TICKS]), controller, rig.calibrations)


class Until:
    """An operator that cuts torque after so many ticks: what comes then is not kept."""

    def __init__(self, operator: Told, ticks: int) -> None:
        self._operator = operator
        self._ticks = ticks

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        if tick is not None and tick.index + 1 >= self._ticks:
            return wish(Intent.CUT, reason=StopReason.EMERGENCY)
        return self._operator.request(tick, t_ns)


def _lean(tick: Tick) -> Tick:
    return replace(tick, inputs=replace(tick.inputs, forces=tick.inputs.forces[-1:], truth=None))


def write(
    path: Path,
    ticks: Iterable[Tick],
    controller: Controller,
    calibrations: tuple[Calibration | None, ...],
) -> None:
    """Write ticks alone, in one chunk: a tenth of an ordinary log."""
    kept = list(ticks)
    kind = "bigant_msgs/msg/Tick"
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=1 << 26, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=LIBRARY)
        schema = writer.register_schema(kind, "ros2msg", DEFINITIONS[kind].encode())
        channel = writer.register_channel(TICK_TOPIC, "cdr", schema)
        details = {
            **controller_metadata(controller, calibrations),
            NAMES_KEY: ",".join(controller.config.parameters.legs.names),
            START_KEY: str(kept[0].t_ns),
            "time": "virtual",
        }
        writer.add_metadata(METADATA_NAME, dict(sorted(details.items())))
        text = controller.config.text.encode()
        writer.add_attachment(0, 0, CONFIG_NAME, "application/toml", text)
        for tick in kept:
            writer.add_message(channel, tick.t_ns, encode_tick(tick), tick.t_ns)
        writer.finish()  # type: ignore[no-untyped-call]


# The change indicator.


def replayed(
    path: Path,
) -> tuple[list[Tick], Controller, tuple[Calibration | None, ...]]:
    """Today's ticks from the recorded inputs."""
    contents = LogContents()
    messages = list(read_tick_messages(path, contents))
    rebuilt = rebuild_controller(contents)
    notes: list[str] = []
    ticks = [tick for _, _, tick in step_through(path, messages, rebuilt.controller, notes)]
    assert not notes, notes
    return ticks, rebuilt.controller, rebuilt.run.calibrations


def indicator(ticks: list[Tick], names: tuple[str, ...]) -> list[list[str]]:
    """Rows of the CSV: a header with units, then one row a second."""
    plain = ["x_m", "y_m", "yaw_rad", "height_m", "vx_m_s", "vy_m_s", "yaw_rate_rad_s"]
    per_leg = ("sent_{}_rad", "load_{}_n", "fx_{}_n", "fy_{}_n", "measured_fz_{}_n")
    header = ["t_s", "mode", "stop_reason", "faults", *plain]
    header += [form.format(name) for form in per_leg for name in names]
    rows = [header]
    faults = 0
    for tick in ticks:
        faults += len(tick.faults)
        if tick.index % RATE_HZ and tick is not ticks[-1]:
            continue
        support, traction = tick.contact.support, tick.contact.traction
        numbers = np.concatenate(
            [
                tick.dead_reckoning.position_m,
                [tick.dead_reckoning.yaw_rad, support.height_m],
                traction.velocity_B,
                tick.sent.angle_rad,
                support.load_n,
                traction.force_B[:, 0],
                traction.force_B[:, 1],
                tick.forces.force_n[:, 2],
            ]
        )
        t_s = (tick.t_ns - ticks[0].t_ns) * 1e-9
        words = [f"{t_s:.3f}", tick.mode.name, tick.stop_reason.name, str(faults)]
        rows.append([*words, *(_digits(float(value)) for value in numbers)])
    return rows


def _digits(value: float) -> str:
    rounded = round(value, DECIMALS) + 0.0  # no minus zero
    return f"{rounded:.{DIGITS}g}"


def read_rows(name: str) -> list[list[str]]:
    """The rows of the CSV that is there, none if there is none."""
    path = csv_of(name)
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return [line.split(",") for line in text.splitlines()]


def same(old: str, new: str) -> bool:
    """Equal within one of the last digit: another computer rounds a tie the other way."""
    try:
        one, other = float(old), float(new)
    except ValueError:
        return old == new
    if not (math.isfinite(one) and math.isfinite(other)):
        return old == new
    unit = max(10.0**-DECIMALS, 10.0 ** (math.floor(math.log10(abs(one) or 1.0)) + 1 - DIGITS))
    return abs(one - other) <= 1.5 * unit


def settled(old: list[list[str]], new: list[list[str]]) -> list[list[str]]:
    """The new rows; a number that is the same keeps the digits it had."""
    if [len(row) for row in old] != [len(row) for row in new] or old[0] != new[0]:
        return new
    return [
        [one if same(one, other) else other for one, other in zip(before, after, strict=True)]
        for before, after in zip(old, new, strict=True)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", action="store_true", help="run the virtual robot again")
    anew = parser.parse_args().record
    FOLDER.mkdir(exist_ok=True)
    for name in NAMES:
        path = log_of(name)
        if anew or not path.exists():
            record(name)
        ticks, controller, calibrations = replayed(path)
        found = replay_log(path)
        if not found.equal or not found.complete:
            print(f"{name}: outputs have changed; the log gets today's")
            write(path, ticks, controller, calibrations)
        rows = settled(read_rows(name), indicator(ticks, controller.config.parameters.legs.names))
        csv_of(name).write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
        print(f"{name}: {len(ticks)} ticks, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
