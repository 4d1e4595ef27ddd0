"""What a force-torque unit is asked before it streams: its calibration, its console, where it is."""

import numpy as np
import pytest

from drivers.ati.calibration import parse_cal
from drivers.ati.console import Console
from drivers.ati.discovery import DiscoveredUnit, answer, parse_answer, question
from model.errors import ForceStreamError
from sim_hw.ati.console import ConsoleSession
from sim_hw.ati.unit import VirtualWnet
from sim_hw.clock import VirtualClock
from tests.drivers.test_ati_stream import SteadyLoad

# The calibration table.

REAL = """CAL
Tr Cal   Gain Offset Row           G0        G1        G2        G3        G4        G5  Properties
-- ---   ---- ------ ---           --        --        --        --        --        --  ----------
 1   1    600  32000   0 Fx    -300.1    -200.2     350.3  -32000.4    -220.5   32800.6  Serial: FT00001
 1   1    601  32001   1 Fy     216.1   37400.2      57.3  -18800.4     351.5  -18800.6  Date:   2023/5/1
 1   1    602  32002   2 Fz   18480.1    -250.2   18750.3    -412.4   18600.5    -588.6  Part:   SI-130-10
 1   1    603  32003   3 Tx      53.1     156.2    -322.3       8.4     322.5     -12.6  Force:  {force}
 1   1    604  32004   4 Ty     373.1      -6.2    -184.3       6.4    -184.5       6.6  Torque: {torque}
 1   1    605  32005   5 Tz       5.1    -198.2       3.3    -197.4       2.5    -196.6  Mult:   ON
 1                 0 MaxRatings:
 1                 0              130       130       400        10        10        10 
"""  # noqa: W291


def test_calibration_is_read_by_its_labels() -> None:
    text = REAL.format(force="1000000 counts/N", torque="1000000 counts/N-m")
    calibration = parse_cal(text, 1)
    assert calibration.serial == "FT00001"
    assert calibration.part == "SI-130-10"
    assert calibration.counts_per_n == 1e6
    assert calibration.max_rating == (130, 130, 400, 10, 10, 10)
    assert calibration.mult_on
    assert calibration.calibrated


def test_counts_per_newton_millimetre_are_not_per_metre() -> None:
    text = REAL.format(force="1000 counts/lbf", torque="1000000 counts/N-mm")
    calibration = parse_cal(text, 1)
    assert calibration.counts_per_nm == pytest.approx(1e9)
    assert calibration.counts_per_n == pytest.approx(224.8089)


@pytest.mark.parametrize("force", ["0 counts/", "1000 counts/furlong", "nothing"])
def test_a_scale_that_means_nothing_is_refused(force: str) -> None:
    with pytest.raises(ForceStreamError, match="which is no scale we know"):
        parse_cal(REAL.format(force=force, torque="1 counts/N-m"), 1)


# The console.


class Scripted:
    """A console that answers with prepared pieces."""

    def __init__(self, clock: VirtualClock, *pieces: bytes) -> None:
        self._clock = clock
        self._pieces = list(pieces)
        self._ready: list[bytes] = []

    def write(self, data: bytes) -> None:
        if data.strip():
            self._ready = self._pieces

    def read(self, timeout_s: float) -> bytes:
        if self._ready:
            return self._ready.pop(0)
        self._clock.advance(round(timeout_s * 1e9))
        return b""

    def close(self) -> None:
        pass


def test_an_answer_in_pieces_behind_late_bytes_and_telnet_options() -> None:
    clock = VirtualClock()
    link = Scripted(
        clock, b"\xff\xfd\x03\r\n>", b"ra", b"te\r\nPacket rate =  125 Hz\r", b"\nADC > 3\r\n", b">"
    )
    assert Console(link, clock).query("rate") == "Packet rate =  125 Hz\r\nADC > 3"


def test_no_answer_is_an_error_in_time() -> None:
    clock = VirtualClock()
    with pytest.raises(ForceStreamError, match="did not answer 'rate' in 3 s"):
        Console(Scripted(clock, b"rate\r\nPacket"), clock).query("rate")


@pytest.mark.parametrize("command", ["CAL MATRIX 0 1 2", "NET KEY", "FDEL x", "cal serial 1"])
def test_what_writes_to_the_sensor_is_never_sent(command: str) -> None:
    clock = VirtualClock()
    with pytest.raises(ForceStreamError, match="not sent"):
        Console(Scripted(clock), clock).query(command)


def test_the_virtual_console_speaks_like_the_real_one() -> None:
    unit = VirtualWnet(SteadyLoad(), (1, 2, 3, 4, 5, 6))
    session = ConsoleSession(unit)
    session.take(0)  # its greeting

    def printed(sent: bytes) -> bytes:
        session.give(sent, 0)
        return session.take(0)

    assert printed(b"\r\n") == b"\r\n>"
    assert printed(b"rate 125 16\r\n") == (
        b"rate 125 16\r\nPacket rate =  125 Hz\r\nADC    rate = 2000 Hz\r\nOversample  =   16\r\n>"
    )
    assert printed(b"trans 2\r\n") == (b"trans 2\r\nActive: Transducer = 2 Calibration = 1\r\n>")
    assert b"must not exceed 4000" in printed(b"rate 1000 32\r\n")


# Discovery.


def test_discovery_bytes() -> None:
    assert question() == bytes.fromhex(
        "52 54 41 20 44 65 76 69 63 65 20 44 69 73 63 6f 76 65 72 79 52 54 41 44"
        "02 04 e0 00 05 80 f2 01 07"
    )
    reply = bytes.fromhex(
        "52 54 41 44 01 06 00 23 a7 0c 3d 5e 02 04 c0 a8 00 03 03 04 ff ff ff 00"
        "0d 0c 57 69 72 65 6c 65 73 73 20 46 2f 54 86 05 62 65 6e 63 68"
    )
    unit = DiscoveredUnit("192.168.0.3", "00:23:a7:0c:3d:5e", "Wireless F/T", "bench")
    assert parse_answer(reply) == unit
    assert answer(unit) == reply
    assert parse_answer(reply.replace(b"Wireless F/T", b"Net F/T box!")) is None


class Chatter:
    """A console that prints all the time, as with DUMP ON."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock = clock

    def write(self, data: bytes) -> None:
        pass

    def read(self, _timeout_s: float) -> bytes:
        self._clock.advance(10_000_000)
        return b"4e886762 0004085e 00150aaa 01050009 07 1f\r\n"

    def close(self) -> None:
        pass


def test_a_console_that_never_stops_printing_is_an_error_in_time() -> None:
    clock = VirtualClock()
    with pytest.raises(ForceStreamError, match="prints all the time"):
        Console(Chatter(clock), clock).query("RATE 100 32")
    assert clock.now_ns() < 3_100_000_000


def test_garbled_numbers_of_a_calibration_are_no_scale_and_no_rating() -> None:
    text = REAL.format(force="1.000.000 counts/N", torque="1 counts/N-m")
    with pytest.raises(ForceStreamError, match="no scale we know"):
        parse_cal(text, 1)
    text = REAL.format(force="1 counts/N", torque="1 counts/N-m").replace("130   ", "1x0   ", 1)
    assert np.isnan(parse_cal(text, 1).max_rating[0])
