"""Runs of the whole loop on a bench in virtual time, with a scenario and a robot file changed by words."""

from collections.abc import Mapping
from dataclasses import dataclass

from model.values.faults import FaultKind, StopReason
from model.values.tick import Intent, Mode, Tick
from robot.config.robot_file import RobotConfig, parse_robot
from robot.control.controller import Controller
from robot.run.loop import RunResult, run
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.faults.scenario import parse_scenario
from sim_hw.host.bench_world import BenchWorld
from tests.robot.runs import CONFIG, Kept, Told, modes_of, wish

WEIGHT_N = CONFIG.parameters.body.mass * 9.80665


@dataclass(frozen=True, slots=True)
class BenchRun:
    result: RunResult
    ticks: list[Tick]

    def first(self, kind: FaultKind) -> tuple[float, str]:
        """When a fault was first in a tick, seconds after the first tick, and its words."""
        return next(
            ((t.t_ns - self.ticks[0].t_ns) * 1e-9, f"{f.source}: {f.detail}")
            for t in self.ticks
            for f in t.faults
            if f.kind is kind
        )

    @property
    def modes(self) -> list[Mode]:
        return modes_of(self.ticks)

    @property
    def kinds(self) -> set[FaultKind]:
        return {f.kind for t in self.ticks for f in t.faults} - {FaultKind.NO_SUPPORT}


def changed(changes: Mapping[str, str] | None = None, more: str = "") -> RobotConfig:
    """Return the robot file with some words replaced and something added."""
    text = CONFIG.text
    for old, new in (changes or {}).items():
        assert old in text
        text = text.replace(old, new)
    return parse_robot(text + "\n" + more)


def bench_run(
    faults: str = "",
    *,
    config: RobotConfig = CONFIG,
    seconds: float = 8.0,
    weight_n: float = WEIGHT_N,
    begins: str = "torque",
    seed: int = 0,
    estimate: bool = False,
) -> BenchRun:
    """Walk for so long, then end; stops come first. The estimator is off unless asked for."""
    scenario = parse_scenario(f'seed = {seed}\nbegins = "{begins}"\n{faults}', range(1, 7))
    rig = open_in_memory(
        config,
        VirtualSettings(seed=seed, scenario=scenario),
        bench=lambda firmware: BenchWorld(
            firmware,
            config.servo_bus.zeros,
            weight_n,
            config.servo_bus.models,
            config.parameters.servo.supply_voltage,
        ),
    )
    kept = Kept()
    done = wish(Intent.CUT, reason=StopReason.COMPLETED)

    def tell(t: float, tick: Tick | None):  # type: ignore[no-untyped-def]
        stopping = tick is not None and tick.stop_reason is not StopReason.NONE
        return done if t > seconds and not stopping else wish(Intent.WALK, frequency_hz=0.25)

    try:
        controller = Controller(config, rig.calibrations, armed=True, estimate=estimate)
        return BenchRun(run(rig, controller, Told(tell), kept, None), kept.ticks)
    finally:
        rig.close()
