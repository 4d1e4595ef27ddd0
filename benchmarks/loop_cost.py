"""What one tick costs: the step, the log and the virtual robot, as shares of one run.

Run it with ``python benchmarks/loop_cost.py``. It prints medians over ticks, of processor time: others on
the machine do not count, but they do slow down what shares a core with them. Results are written up in
docs/performance.md.
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from model.values.tick import Tick
from record.log.tick_message import decode_tick, encode_tick
from record.log.writer import LogWriter
from robot.config.robot_file import load_robot
from robot.control.controller import Controller
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.virtual.open import open_in_memory


class Collector:
    """A sink that keeps ticks."""

    error = None

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def write(self, tick: Tick) -> None:
        self.ticks.append(tick)


def median_us(action: Callable[[Tick], object], ticks: list[Tick]) -> float:
    times = []
    for tick in ticks:
        began = time.process_time_ns()
        action(tick)
        times.append((time.process_time_ns() - began) / 1e3)
    return statistics.median(times)


def main() -> None:
    config = load_robot()
    rig = open_in_memory(config)
    controller = Controller(config, rig.calibrations, armed=True)
    script = Script("tripod", 0.1, 0.0, cycles=None, duration_s=5.0)
    sink = Collector()
    began = time.perf_counter()
    run(rig, controller, ScriptedOperator(script, Interrupts()), sink, None)
    wall_s = time.perf_counter() - began
    ticks = sink.ticks
    virtual_s = (ticks[-1].t_ns - ticks[0].t_ns) * 1e-9
    state = controller.initial()

    def step(tick: Tick) -> None:
        nonlocal state
        state, _ = controller.step(state, tick.inputs, tick.t_ns)

    with tempfile.TemporaryDirectory() as folder:
        writer = LogWriter(
            Path(folder) / "log.mcap",
            names=config.parameters.legs.names,
            config_text="",
            metadata={},
            start_ns=ticks[0].t_ns,
            start_unix_ns=0,
        )
        rows = {
            "step (calibration, watch, gait, gate, linkage, support, traction, estimator)": median_us(
                step, ticks
            ),
            "log, all topics of a tick": median_us(writer.write, ticks),
            "encode a tick": median_us(encode_tick, ticks),
            "decode a tick": median_us(lambda t: decode_tick(encode_tick(t)), ticks),
        }
        writer.close()
    for label, value in rows.items():
        print(f"{value:8.0f} us  {label}")
    print(f"virtual robot in memory, everything included: {virtual_s / wall_s:.2f} x real time")


if __name__ == "__main__":
    main()
