"""``bigant check`` listens to an IMU: sound ones pass, each wrong one is told with what to do."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest

from drivers.lines.imu import ImuListener, imu_line
from model.values.readings import ImuRecord
from robot.bringup.preflight.finding import CheckVerdict, Finding
from robot.bringup.preflight.imu import imu_findings
from robot.config.imu import ImuConfig
from sim_hw.clock import VirtualClock

PASS, WARN, FAIL = CheckVerdict.PASS, CheckVerdict.WARN, CheckVerdict.FAIL
UPSIDE_DOWN = ImuConfig(port="x", mounting=(pi, 0.0, 0.0))


class Printing:
    """A source that prints a line each so many nanoseconds."""

    def __init__(
        self, clock: VirtualClock, print_line: Callable[[int], str], period_ns: int
    ) -> None:
        self._clock, self._print, self._period_ns = clock, print_line, period_ns
        self._due_ns = clock.now_ns()

    def receive(self) -> list[str]:
        lines = []
        while self._due_ns <= self._clock.now_ns():
            lines.append(self._print(self._due_ns))
            self._due_ns += self._period_ns
        return lines

    def close(self) -> None:
        pass


def reading(rate: float, roll: float = 0.01, noise: float = 0.001) -> Callable[[int], str]:
    draw = np.random.default_rng(0)
    return lambda t_ns: imu_line(
        ImuRecord(t_ns, rate + noise * float(draw.normal()), roll, 0.02), 0
    )


def checked(
    print_line: Callable[[int], str], config: ImuConfig | None = None, period_ns: int = 10_000_000
) -> Finding:
    clock = VirtualClock(start_ns=10**9)
    source = Printing(clock, print_line, period_ns)
    listener = ImuListener(source, clock, clock.now_ns(), 0.2)
    config = config if config is not None else ImuConfig(port="x")
    (finding,) = imu_findings(listener, config, clock, 2.0)
    return finding


def test_a_sound_imu_passes() -> None:
    finding = checked(reading(0.002))
    assert finding.verdict is PASS
    assert "100 readings a second, yaw rate 2." in finding.found
    assert "roll 0.6, pitch 1.1 deg" in finding.found
    assert (
        checked(
            lambda t_ns: imu_line(ImuRecord(t_ns, 1e-12 * (t_ns % 97), np.nan, np.nan), 0)
        ).verdict
        is PASS
    )
    assert checked(reading(0.0, pi - 0.01), UPSIDE_DOWN).verdict is PASS


@pytest.mark.parametrize(
    ("print_line", "config", "period_ns", "verdict", "words"),
    [
        (reading(0.3), None, 10_000_000, WARN, "check its unit"),
        (reading(0.0, roll=pi), None, 10_000_000, WARN, "mounting"),
        (reading(0.0), UPSIDE_DOWN, 10_000_000, WARN, "mounting"),
        (reading(0.0), None, 500_000_000, WARN, "at least 10 readings"),
        (lambda _: "hello", None, 10_000_000, FAIL, "what it prints"),
        (lambda _: "# nothing", None, 10_000_000, FAIL, "what it prints"),
        (lambda t: imu_line(ImuRecord(t, 0.1, 0.0, 0.0), 10**10), None, 10_000_000, FAIL, "prints"),
    ],
)
def test_what_is_wrong_is_told(
    print_line: Callable[[int], str],
    config: ImuConfig | None,
    period_ns: int,
    verdict: CheckVerdict,
    words: str,
) -> None:
    finding = checked(print_line, config, period_ns)
    assert finding.verdict is verdict, finding
    assert words in finding.advice
