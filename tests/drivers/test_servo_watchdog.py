"""The proof that the servos' own watchdog stops them, and what it does with the torque."""

import pytest

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.watchdog import prove_watchdog
from model.errors import BusError
from sim_hw.dynamixel.bus import VirtualServoBus
from tests.drivers.test_servo_bus import SETTINGS, armed, make_bench


def test_every_watchdog_trips_and_torque_is_off_afterwards() -> None:
    bench = make_bench()
    bench.bus.connect()
    bench.bus.configure()
    before = bench.motors.ticks.copy()
    proof = prove_watchdog(bench.bus)
    assert proof.tripped == SETTINGS.names
    assert proof.asleep == ()
    assert proof.torque_off
    assert proof.silent_s == pytest.approx(0.34)
    assert [s.table.get("torque_enable") for s in bench.servos.servos] == [0] * 6
    assert [s.table.get("bus_watchdog") for s in bench.servos.servos] == [0] * 6
    assert abs(bench.motors.ticks - before).max() < 5, "nothing moved"


def test_a_watchdog_that_sleeps_is_named() -> None:
    bench = armed()
    bench.bus.torque_off()
    deaf = bench.servos.servos[4]
    check = deaf.check
    deaf.check = lambda t_ns, motors: None  # type: ignore[method-assign]  # never looks at the time
    proof = prove_watchdog(bench.bus)
    deaf.check = check  # type: ignore[method-assign]
    assert proof.asleep == ("MR",)
    assert len(proof.tripped) == 5
    assert proof.torque_off


def test_the_proof_needs_an_armed_bus() -> None:
    bench = make_bench()
    bench.bus.connect()
    with pytest.raises(BusError, match="--armed"):
        prove_watchdog(bench.bus)


def test_a_servo_that_falls_silent_in_the_proof_leaves_no_torque() -> None:
    def prepare(servos: VirtualServoBus) -> None:
        servos.servos[0].table.set("operating_mode", 4)

    bench = make_bench(prepare)
    bench.bus.connect()
    bench.bus.configure()
    sleep = bench.clock.sleep_until_ns

    def lose_one(t_ns: int) -> None:
        bench.servos.silence(6)
        sleep(t_ns)

    bench.clock.sleep_until_ns = lose_one  # type: ignore[method-assign]
    with pytest.raises(BusError, match="FR"):
        prove_watchdog(bench.bus)
    assert [s.table.get("torque_enable") for s in bench.servos.servos[:5]] == [0] * 5
    assert MX_106.table["torque_enable"].address == 64
