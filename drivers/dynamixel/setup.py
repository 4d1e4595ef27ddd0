"""Finding the servos of a robot, and bringing them into the state the loop needs.

Finding only asks. Setting up writes, and to EEPROM only what differs, with torque off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from dynamixel_sdk import COMM_SUCCESS, Protocol1PacketHandler

from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.checked_servo import TRIES, CheckedServo
from drivers.dynamixel.frames import LARGEST_ID, Instruction
from drivers.dynamixel.model_words import mismatch_words, protocol_1_words
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.registers import OperatingMode, hardware_error_names
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import RETURN_DELAY_UNIT_S, TICKS_PER_TURN, VOLTAGE_UNIT_V
from model.errors import BusError

PING_TRIES = 5
LONGEST_QUIET_RETURN_DELAY = 1  # 2 us
WARN_LATENCY_MS = 4.0
# Beyond this many turns the turn counter is set back before walking: the range ends at 256.
TURNS_TO_CLEAR = 200
REVERSE = 0x01  # of drive_mode


@dataclass(frozen=True, slots=True)
class ServoIdentity:
    """One servo as it introduced itself.

    Attributes:
        leg: Leg name.
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        return_delay: Register 9, in units of 2 us.
        voltage_v: Supply voltage.
    """

    leg: str
    servo_id: int
    model: int
    firmware: int
    return_delay: int
    voltage_v: float


@dataclass(frozen=True, slots=True)
class BusReport:
    """What connecting found out.

    Attributes:
        servos: The servos, in leg order.
        warnings: What should be corrected, one sentence each.
    """

    servos: tuple[ServoIdentity, ...]
    warnings: tuple[str, ...]


def find_servos(
    port: ClockedPort, servos: Sequence[CheckedServo], settings: ServoBusSettings
) -> BusReport:
    """Ask every servo who it is. Writes nothing.

    Raises:
        BusError: One is missing, of another kind, or in a state that cannot be worked with.
    """
    identities = [_ping(servo).data for servo in servos]
    missing = [s for s, identity in zip(servos, identities, strict=True) if identity is None]
    if missing:
        words = _missing_words(port, settings, missing)
        raise BusError(words, port=port.name, ids=tuple(s.servo_id for s in missing))
    connected: list[ServoIdentity] = []
    warnings: list[str] = []
    for servo, expected, identity in zip(servos, settings.models, identities, strict=True):
        data = identity or b""
        model, firmware = COMMON["model_number"].decode(data[:2]), data[2]
        _check_model(servo, expected, model)
        warnings += _check_state(servo, expected, firmware)
        connected.append(
            ServoIdentity(
                leg=servo.leg,
                servo_id=servo.servo_id,
                model=model,
                firmware=firmware,
                return_delay=servo.read("return_delay_time"),
                voltage_v=servo.read("present_input_voltage") * VOLTAGE_UNIT_V,
            )
        )
    warnings += _unmeasured_words(settings)
    return BusReport(tuple(connected), (*_bus_warnings(port, connected), *warnings))


def configure_servos(servos: Sequence[CheckedServo]) -> None:
    """Torque off, watchdog clear, extended position mode, every request answered, few turns.

    Raises:
        BusError: A servo does not take a setting.
    """
    for servo in servos:
        configure_servo(servo)
        if abs(servo.read("present_position")) > TURNS_TO_CLEAR * TICKS_PER_TURN:
            servo.clear_turns()


def configure_servo(servo: CheckedServo) -> None:
    """Bring one servo into extended position mode, torque off, watchdog clear, no profile.

    Raises:
        BusError: It does not take a setting.
    """
    servo.answer_everything()
    servo.write_verified("torque_enable", 0)  # EEPROM is locked while it is on
    servo.write_verified("bus_watchdog", 0)
    servo.ensure("operating_mode", OperatingMode.EXTENDED_POSITION)
    servo.write("profile_velocity", 0)
    servo.write("profile_acceleration", 0)


def hold_here(servo: CheckedServo) -> int:
    """Switch one servo's torque on with its goal where the shaft stands.

    Position and goal are read right before, each as a run of bytes of a length of its own: an answer that
    comes late cannot pass for either, and a goal that was lost on the way is written again. With an old
    goal in its register the shaft would turn the moment torque goes on.

    Args:
        servo: The servo, configured.

    Returns:
        Where it holds [ticks].

    Raises:
        BusError: It does not do it; its torque has not been switched on then.
    """
    servo.write_verified("bus_watchdog", 0)  # a tripped one takes no goal
    for _ in range(TRIES):
        ticks = servo.read_run("present_velocity", "present_position")["present_position"]
        servo.write("goal_position", ticks)
        kept = servo.read_run("goal_position", "realtime_tick")["goal_position"]
        if kept == ticks:
            servo.write_verified("torque_enable", 1)
            return ticks
    raise servo.error(
        f"has goal_position {kept} instead of {ticks} where it stands; torque stays off: check its cable",
        "goal_position",
    )


def _ping(servo: CheckedServo) -> ServoAnswer:
    answer = servo.packets.ask(servo.servo_id, Instruction.PING)
    for _ in range(PING_TRIES - 1):
        if answer.data is not None:
            break
        answer = servo.packets.ask(servo.servo_id, Instruction.PING)
    return answer


def _missing_words(
    port: ClockedPort, settings: ServoBusSettings, missing: Sequence[CheckedServo]
) -> str:
    old = [servo for servo in missing if speaks_protocol_1(servo)]
    if old:
        return f"{_who(old)}: {protocol_1_words(settings.model_of_leg[old[0].leg].name)}"
    where = f"on {port.name} at {settings.baud_rate} baud"
    others = len(settings.names) - len(missing)
    if not others:
        return (
            f"no servo answers {where}: check power and cable, and whether the baud rate is right "
            f"with: bigant devices --port {port.name}"
        )
    verb = "does" if len(missing) == 1 else "do"
    others_words = "1 other does" if others == 1 else f"{others} others do"
    return (
        f"{_who(missing)} {verb} not answer {where}, {others_words}: check cable, id and baud rate "
        f"with: bigant devices --port {port.name}"
    )


def _who(servos: Sequence[CheckedServo]) -> str:
    return ", ".join(servo.who for servo in servos)


def speaks_protocol_1(servo: CheckedServo) -> bool:
    """Ask in the old protocol: a servo with the old firmware is deaf to the new one."""
    _, code, _ = Protocol1PacketHandler().ping(servo.port, servo.servo_id)
    return bool(code == COMM_SUCCESS)


def _check_model(servo: CheckedServo, expected: ServoModel, number: int) -> None:
    words = mismatch_words(expected, number)
    if words:
        raise servo.error(words, "model_number")


def _check_state(servo: CheckedServo, model: ServoModel, firmware: int) -> list[str]:
    """Return warnings about one servo; raise for what cannot be worked with."""
    if not servo.answers_reads():
        raise servo.error(
            f"answers a ping and no read on {servo.port.name}: its status return level may be 0, "
            "so switch its power off and on",
            "status_return_level",
        )
    warnings = []
    error = servo.read("hardware_error_status")
    names = ", ".join(hardware_error_names(error))
    if error & servo.read("shutdown"):
        raise servo.error(
            f"has shut down ({names}): remove the cause, then switch its power off and on",
            "hardware_error_status",
        )
    if error:
        warnings.append(f"{servo.who} reports {names}: look for the cause before it walks")
    offset = servo.read("homing_offset")
    if offset != 0:
        raise servo.error(
            f"has a homing offset of {offset}: set it to 0 with Dynamixel Wizard and put it "
            "into servo_zero (with an offset, a tripped watchdog can leave the motor running)",
            "homing_offset",
        )
    drive_mode = servo.read("drive_mode")
    if drive_mode:
        sense = "turns backwards" if drive_mode & REVERSE else "takes profiles for times"
        raise servo.error(
            f"{sense} (drive_mode is {drive_mode}): set it to 0 with bigant servo setup; "
            "servo_sign in the robot file turns the sense",
            "drive_mode",
        )
    shadow = servo.read("secondary_id")
    if shadow <= LARGEST_ID:
        raise servo.error(
            f"also obeys id {shadow} (secondary_id): set it to 255 with bigant servo setup",
            "secondary_id",
        )
    warnings += _limit_warnings(servo)
    if firmware < model.watchdog_firmware:
        warnings.append(
            f"{servo.who} has firmware {firmware}, which has no bus watchdog: update it with "
            "Dynamixel Wizard"
        )
    return warnings


def _limit_warnings(servo: CheckedServo) -> list[str]:
    """Return what in the servo's own limits keeps it from its full strength, or from shutting down."""
    lines = []
    for name in ("pwm_limit", "shutdown"):
        there, usual = servo.read(name), servo.table[name].initial
        if there != usual:
            lines.append(
                f"{servo.who} has {name} {there} and not {usual}: compare with bigant servo setup"
            )
    return lines


def _unmeasured_words(settings: ServoBusSettings) -> list[str]:
    """Return, once, which servos have no current that could be judged."""
    without = [
        (leg, model.name)
        for leg, model in zip(settings.names, settings.models, strict=True)
        if not model.measures_current
    ]
    if not without:
        return []
    legs, names = ", ".join(leg for leg, _ in without), ", ".join(sorted({n for _, n in without}))
    return [f"{legs}: an {names} measures no current, so no limit on current is judged there"]


def _bus_warnings(port: ClockedPort, servos: Sequence[ServoIdentity]) -> list[str]:
    warnings = []
    slow = [servo for servo in servos if servo.return_delay > LONGEST_QUIET_RETURN_DELAY]
    if slow:
        delay_us = max(servo.return_delay for servo in slow) * RETURN_DELAY_UNIT_S * 1e6
        legs = ", ".join(servo.leg for servo in slow)
        warnings.append(
            f"{legs} wait {delay_us:.0f} us before they answer, once a servo and tick: set their "
            "return delay time to 0 with Dynamixel Wizard"
        )
    latency_ms = port.latency_timer_ms
    if latency_ms is not None and latency_ms > WARN_LATENCY_MS:
        warnings.append(
            f"{port.name} holds answers back for up to {latency_ms:.0f} ms: set its latency_timer "
            "to 1"
        )
    return warnings
