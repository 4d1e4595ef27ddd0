"""What no source tells about the devices, as settings: each default is an assumption, not a finding.

A scenario file can change every one of them (tables ``servo``, ``force_unit`` and ``adapter``), so that a
driver can be tried against the other possibility as well.
"""

from dataclasses import dataclass

from sim_hw.typed_table import among, within


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoAssumed:
    """What the e-manual leaves open about the MX-106(2.0).

    Attributes:
        reserved: What a read across the reserved gaps of the control table gives: ``zeros``, or ``error``
            (Access Error, no data). Unverified either way; zeros is assumed.
        firmware: Firmware version; assumed, the newest one is not known.
        overload_current_a: Motor current that counts as overload [A]; assumed, 80 % of stall current.
        overload_s: How long it must last [s]; assumed.
        processing_s: The servo's own work before it answers [s]; measured by others at about 50 us.
        restart_s: How long it is deaf after a reboot or when its supply is back [s]; 0.1 to 0.8 are seen,
            0.25 is assumed.
        watchdog_hears: Whether the bus watchdog counts instruction packets to ``all`` ids or ``own`` ones;
            the e-manual says "any", read as all.
        answers_bad_crc: Whether an instruction with a wrong CRC is answered with a CRC error; assumed not.
        old_firmware: Ids of servos that have protocol 1.0 firmware (model 320).
    """

    reserved: str = among("zeros", "error")
    firmware: int = within(45, 0, 255)
    overload_current_a: float = within(4.2, 0.0, 20.0)
    overload_s: float = within(2.0, 0.0, 1e3)
    processing_s: float = within(50e-6, 0.0, 0.1)
    restart_s: float = within(0.25, 0.0, 3.0)
    watchdog_hears: str = among("all", "own")
    answers_bad_crc: bool = False
    old_firmware: tuple[int, ...] = within((), 0, 252)


@dataclass(frozen=True, slots=True, kw_only=True)
class WnetAssumed:
    r"""What no source tells about the WNet.

    Attributes:
        acknowledges: Whether a command is sent back as its acknowledgement; assumed not.
        sequence_restarts: Whether a start sets the sequence number back; assumed not.
        battery: Battery byte; its encoding is unknown, 7 was seen.
        extra_status: Bits set in status word 1 besides the known ones (12-15, 22-23, 30-31 are unknown).
        adc_clock_hz: A record's period is a whole number of these ticks; 0 for exact rates (assumed).
        bias_samples: Records that a bias averages over; assumed 1.
        banner: Whether the console greets.
        empty_line: What an empty line is answered with; ``\r\n>`` is assumed.
        unknown_command: What an unknown command is answered with, before the word; assumed.
        blank_line: Whether a blank line comes before each prompt; assumed not.
        application: Application text of a discovery answer; must hold ``Wireless F/T`` to be listed.
    """

    acknowledges: bool = False
    sequence_restarts: bool = False
    battery: int = within(7, 0, 255)
    extra_status: int = within(0, 0, 2**32 - 1)
    adc_clock_hz: int = within(0, 0, 1_000_000)
    bias_samples: int = within(1, 1, 10_000)
    banner: bool = True
    empty_line: str = "\r\n>"
    unknown_command: str = "Unknown command: "
    blank_line: bool = False
    application: str = "Wireless F/T (virtual)"


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterAssumed:
    """The USB adapter of the servo bus.

    Attributes:
        latency_timer_s: Replies reach the host in steps of this time unless 62 bytes are waiting, as an
            FTDI chip does; 0 hands every reply over at once (the default, for a pseudo-terminal has none).
            That the steps are a free-running grid is assumed.
    """

    latency_timer_s: float = within(0.0, 0.0, 0.255)


SERVO_ASSUMED = ServoAssumed()
WNET_ASSUMED = WnetAssumed()
