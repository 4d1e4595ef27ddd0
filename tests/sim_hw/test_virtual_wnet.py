"""The virtual WNet: schedule, sample counts, and the CAL table to the byte."""

import zlib

import numpy as np

from drivers.ati.packets import Malformed, UnitCommand, build_command, parse_datagram
from model.values.arrays import FloatArray
from sim_hw.ati.console import CalTable, ConsoleSession, format_cal
from sim_hw.ati.unit import VirtualWnet

ROWS = (
    (600, 32000, (-300.1, -200.2, 350.3, -32000.4, -220.5, 32800.6)),
    (601, 32001, (216.1, 37400.2, 57.3, -18800.4, 351.5, -18800.6)),
    (602, 32002, (18480.1, -250.2, 18750.3, -412.4, 18600.5, -588.6)),
    (603, 32003, (53.1, 156.2, -322.3, 8.4, 322.5, -12.6)),
    (604, 32004, (373.1, -6.2, -184.3, 6.4, -184.5, 6.6)),
    (605, 32005, (5.1, -198.2, 3.3, -197.4, 2.5, -196.6)),
)


class Still:
    def wrench(self, t_ns: int) -> FloatArray:
        return np.zeros((6, 6))


def unit() -> VirtualWnet:
    return VirtualWnet(Still(), (1, 2, 3, 4, 5, 6))


def test_the_cal_table_is_the_real_ones_to_the_byte() -> None:
    table = CalTable(
        transducer=1,
        calibration=1,
        rows=ROWS,
        serial="FT00001",
        date="2023/5/1",
        part="SI-130-10",
        force="1000000 counts/N",
        torque="1000000 counts/N-m",
        mult=True,
        max_rating=(130, 130, 400, 10, 10, 10),
    )
    text = "\r\n".join(["CAL", *format_cal(table)]) + "\r\n>"
    body = text.encode("ascii")
    assert len(body) == 986
    assert zlib.crc32(body) == 0x2A58AFA7


def test_it_stops_by_itself_after_the_samples_asked_for() -> None:
    wnet = unit()
    wnet.command(build_command(UnitCommand.START, 25), 0, 49152)
    assert len(wnet.poll(10_000_000_000)) == 25
    assert wnet.poll(20_000_000_000) == []


def test_endless_until_stop() -> None:
    wnet = unit()
    wnet.command(build_command(UnitCommand.START, 0), 0, 49152)
    assert len(wnet.poll(1_000_000_000)) == 125
    wnet.command(build_command(UnitCommand.STOP), 1_000_000_000, 49152)
    assert wnet.poll(2_000_000_000) == []
    assert wnet.next_due_ns() is None


def test_damaged_commands_are_ignored_and_counted() -> None:
    wnet = unit()
    assert wnet.command(b"\x00\x06\x00\x02\x00\x00", 0, 49152) is False
    assert wnet.ignored == 1


def test_a_transducer_without_power_is_not_in_the_record() -> None:
    wnet = unit()
    ConsoleSession(wnet).give(b"XPWR 2 OFF\r\n", 0)
    wnet.command(build_command(UnitCommand.START, 1), 0, 49152)
    (_, data), *_ = wnet.poll(1_000_000_000)
    parsed = parse_datagram(data, 0)
    assert not isinstance(parsed, Malformed)
    assert parsed[0].mask == 0b111101
    assert len(data) == 138


def test_device_bias_takes_the_last_sample_for_zero() -> None:
    wnet = VirtualWnet(Still(), (1, 2, 3, 4, 5, 6), noise=(0.0,) * 6)
    wnet._source = type("Load", (), {"wrench": lambda _s, _t: np.full((6, 6), 2.0)})()
    wnet.command(build_command(UnitCommand.START, 0), 0, 49152)
    wnet.poll(10_000_000)
    ConsoleSession(wnet).give(b"BIAS * ON\r\n", 0)
    (_, data), *_ = wnet.poll(20_000_000)
    parsed = parse_datagram(data, 0)
    assert not isinstance(parsed, Malformed)
    assert (parsed[0].counts == 0).all()


def test_the_same_seed_gives_the_same_bytes() -> None:
    streams = []
    for _ in range(2):
        wnet = VirtualWnet(Still(), (1, 2, 3, 4, 5, 6), seed=3)
        wnet.command(build_command(UnitCommand.START, 0), 0, 49152)
        streams.append(b"".join(data for _, data in wnet.poll(1_000_000_000)))
    assert streams[0] == streams[1]
