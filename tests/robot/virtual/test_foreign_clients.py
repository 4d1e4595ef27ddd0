"""Programs of others on ``bigant sim serve``: real firmware would answer them, so ours does.

rustypot is written in Rust by others, from the e-manual: it shares nothing with our drivers. LeRobot's bus
needs a deep-learning framework to be installed; docs/reliability.md says how it was run.
"""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import dynamixel_sdk
import numpy as np
import pytest

from tests.robot.other_servos import XL330, other_robot
from tests.robot.sim_serve import ForkedSim

rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")
IDS = [1, 2, 3, 4, 5, 6]
SECONDS = 5.0  # of patience; the machine may be busy


@pytest.fixture(scope="module")
def bus() -> Iterator[Any]:
    sim = ForkedSim()
    try:
        yield rustypot.Xl430PyController(sim.port, 1_000_000, SECONDS)
    finally:
        sim.close()


@pytest.mark.soak
def test_rustypot_reads_moves_and_reboots(bus: Any) -> None:
    client = bus
    assert [client.ping(i) for i in IDS] == [True] * 6
    assert client.read_model_number(3) == [321]
    assert client.sync_read_present_position(IDS) == [2048] * 6
    client.write_operating_mode(1, 4)
    client.write_torque_enable(1, True)
    client.write_goal_position(1, 2148)
    deadline = time.monotonic() + 60
    while abs(client.read_present_position(1)[0] - 2148) > 15:
        assert time.monotonic() < deadline, "the shaft never came"
    client.sync_write_goal_position([1], [2048])
    assert client.read_goal_position(1) == [2048]
    assert client.reboot(1)
    deadline = time.monotonic() + 60
    while not awake(client):
        assert time.monotonic() < deadline, "it never came back"
    assert client.read_torque_enable(1) == [0]


def test_rustypot_and_the_sdk_talk_to_xl330_servos(tmp_path: Path) -> None:
    """rustypot has a client of its own for them; the vendor's SDK reads what the loop reads."""
    path = tmp_path / "xl330.toml"
    path.write_text(other_robot(*XL330), encoding="utf-8")
    sim = ForkedSim("--robot", str(path), "--no-force-unit")
    try:
        client = rustypot.Xl330PyController(sim.port, 1_000_000, SECONDS)
        assert client.read_model_number(3) == [1200]
        assert client.read_current_limit(3) == [1750]
        assert client.read_present_input_voltage(3)[0] in {49, 50}
        assert client.read_pwm_slope(3) == [140]
        client.write_operating_mode(1, 4)
        client.write_torque_enable(1, True)
        client.write_goal_position(1, 0.46)  # this client takes radians from 2048
        deadline = time.monotonic() + 60
        while client.read_raw_present_position(1)[0] < 2200:  # its gain is low, and the foot rubs
            assert time.monotonic() < deadline, "the shaft never came"
        del client
        port, packets = dynamixel_sdk.PortHandler(sim.port), dynamixel_sdk.PacketHandler(2.0)
        assert port.setBaudRate(1_000_000)
        port.setPacketTimeout = lambda _: port.setPacketTimeoutMillis(SECONDS * 1e3)
        read = dynamixel_sdk.GroupSyncRead(port, packets, 124, 23)
        for number in IDS:
            read.addParam(number)
        assert read.txRxPacket() == 0
        assert {read.getData(i, 144, 2) for i in IDS} <= {49, 50}
        assert {packets.ping(port, i) for i in IDS} == {(1200, 0, 0)}
        port.closePort()
    finally:
        sim.close()


def awake(client: Any) -> bool:
    """Whether servo 1 answers."""
    try:
        return bool(client.ping(1))
    except OSError:
        return False


def test_every_register_that_rustypot_knows_is_answered(bus: Any) -> None:
    names = [
        name
        for name in dir(bus)
        if name.startswith("read_")
        and not name.startswith(("read_raw", "read_backup", "read_register"))
    ]
    answers = {name: getattr(bus, name)(2) for name in names}
    assert len(answers) > 60
    assert all(np.isfinite(value).all() for value in answers.values())
