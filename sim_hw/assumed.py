"""What no source tells about the devices, as settings: each default is an assumption, not a finding.

A scenario file can change every one of them (tables ``servo``, ``force_unit``, ``adapter`` and ``imu``), so
that a driver can be tried against the other possibility as well.
"""

import math
from dataclasses import dataclass

from sim_hw.typed_table import among, value, within


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoAssumed:
    """What the e-manual leaves open about the servos; figures are of the MX-106(2.0)."""

    # ``error`` is an Access Error without data
    reserved: str = among(
        "zeros",
        "error",
        text="What a read across reserved gaps of the control table gives; unverified.",
    )
    firmware: int = within(45, 0, 255, "Firmware version; assumed, the newest one is not known.")
    overload_current_a: float = within(
        4.2,
        0.0,
        20.0,
        "Motor current that counts as overload [A]; assumed, 80 % of an MX-106's stall.",
    )
    overload_s: float = within(2.0, 0.0, 1e3, "How long it must last [s]; assumed.")
    processing_s: float = within(
        50e-6, 0.0, 0.1, "Its own work before it answers [s]; others measured about 50 us."
    )
    # 0.1 to 0.8 s are seen
    restart_s: float = within(
        0.25,
        0.0,
        3.0,
        "How long it is deaf after a reboot or when its supply is back [s]; assumed.",
    )
    # the e-manual says "any", read as all
    watchdog_hears: str = among(
        "all",
        "own",
        text="Whether instruction packets to all ids feed the bus watchdog or own ones.",
    )
    answers_bad_crc: bool = value(
        False, "Whether an instruction with a wrong CRC is answered with a CRC error; assumed not."
    )
    old_firmware: tuple[int, ...] = within(
        (), 0, 252, "Ids of servos that have protocol 1.0 firmware (model 320)."
    )
    shares_id: tuple[int, ...] = within(
        (), 0, 252, "Servos that were given the id of the one before them; both answer at once."
    )
    # the e-manual says neither; a new goal is written before torque goes on either way
    goal_at_torque_on: str = among(
        "kept", "here", text="Whether the goal register is kept at torque on, or becomes here."
    )
    gains_at_mode_change: str = among(
        "reset", "kept", text="Whether a change of the operating mode resets gains and profile."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class WnetAssumed:
    """What no source tells about the WNet."""

    acknowledges: bool = value(
        False, "Whether a command is sent back to acknowledge it; assumed not."
    )
    sequence_restarts: bool = value(
        False, "Whether a start resets the sequence number; assumed not."
    )
    battery: int = within(7, 0, 255, "Battery byte; its encoding is unknown, 7 was seen.")
    extra_status: int = within(
        0, 0, 2**32 - 1, "More bits of status word 1; 12-15, 22-23 and 30-31 are unknown."
    )
    adc_clock_hz: int = within(
        0,
        0,
        1_000_000,
        "A record's period is whole ticks of this clock; 0 for exact rates (assumed).",
    )
    bias_samples: int = within(1, 1, 10_000, "Records that a bias averages over; assumed 1.")
    banner: bool = value(True, "Whether the console greets.")
    empty_line: str = value("\r\n>", r"What an empty line is answered with; ``\r\n>`` is assumed.")
    unknown_command: str = value(
        "Unknown command: ", "What an unknown command is answered with, before the word; assumed."
    )
    blank_line: bool = value(False, "Whether a blank line comes before each prompt; assumed not.")
    application: str = value(
        "Wireless F/T (virtual)",
        "Text of a discovery answer; must hold ``Wireless F/T`` to be listed.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterAssumed:
    """The USB adapter of the servo bus."""

    # as an FTDI chip does; a pseudo-terminal has none. That the steps are a free-running grid is assumed
    latency_timer_s: float = within(
        0.0,
        0.0,
        0.255,
        "Replies come in steps of this unless 62 bytes wait; 0 hands them over at once.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuAssumed:
    """The virtual IMU; figures are of a small MEMS unit at rest in a warm room, assumed."""

    rate_hz: float = within(100.0, 1.0, 1000.0, "Readings a second.")
    yaw_rate_bias_rad_s: float = within(0.005, -1.0, 1.0, "Bias of the gyro at the beginning.")
    yaw_rate_walk: float = within(
        0.0, 0.0, 1.0, "Random walk of that bias [rad/s in a second, one sd]."
    )
    yaw_rate_noise_rad_s: float = within(0.002, 0.0, 1.0, "Noise of each yaw rate (one sd).")
    tilt: bool = value(True, "Whether it reports roll and pitch; else a gyro alone.")
    roll_error_rad: float = within(0.0, -1.0, 1.0, "Added to the roll: it is mounted askew.")
    pitch_error_rad: float = within(0.0, -1.0, 1.0, "The same of the pitch [rad].")
    tilt_noise_rad: float = within(0.001, 0.0, 1.0, "Noise of each angle (one sd).")
    delay_s: float = within(0.0, 0.0, 10.0, "Readings arrive so late; their stamps are right.")
    loss: float = within(0.0, 0.0, 1.0, "Share of its lines that get lost.")
    damage: float = within(0.0, 0.0, 1.0, "Share of its lines that arrive with a bit inverted.")
    silent_after_s: float = within(
        math.inf, 0.0, math.inf, "It falls silent so long after its first reading."
    )
    silent_for_s: float = within(math.inf, 0.0, math.inf, "For so long; for good if not given.")
    stuck_after_s: float = within(
        math.inf, 0.0, math.inf, "Its values never change from so long after its first reading on."
    )


SERVO_ASSUMED = ServoAssumed()
WNET_ASSUMED = WnetAssumed()
