"""One virtual servo: what it measures, obeys, protects itself against.

Decided here, as the manual does not say: a servo counts as standing still for the Clear instruction below
its moving threshold; a homing offset beyond a quarter turn is cut to it in position mode; Protocol Type 1
makes it deaf to protocol 2.0 at once, and it does not speak 1.0 here (see ``old_servos``); a time-based
profile is worked out when its goal comes, as from rest; the load of a servo without a current is its own
output. Not modelled: dual joint (slave) mode, and what X servos know since firmware 45 (fast reads, torque
on by a goal, start-up configuration, backup of the table). Protections: ``sim_hw.dynamixel.protection``.
"""

import math

import numpy as np

from drivers.dynamixel.frames import ALERT, Instruction, StatusError
from drivers.dynamixel.registers import RAM_FROM, Register
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import (
    RETURN_DELAY_UNIT_S,
    TICK_RAD,
    TICKS_PER_TURN,
    VELOCITY_UNIT_RAD_S,
    WATCHDOG_UNIT_S,
)
from sim_hw.assumed import SERVO_ASSUMED, ServoAssumed
from sim_hw.dynamixel import measured_kernel
from sim_hw.dynamixel.control_table import GOAL, ControlTable, measured_run
from sim_hw.dynamixel.firmware import (
    COPIED,
    POSITION,
    TURNED,
    VELOCITY,
    FirmwareBank,
)
from sim_hw.dynamixel.protection import Protection
from sim_hw.interfaces import MotorReadings, MotorWorld

# Registers that a change of mode sets: first and last of each run.
GAINS, PROFILE = ("velocity_i_gain", "feedforward_1st_gain"), ("goal_velocity", "profile_velocity")
CLEAR_MULTI_TURN = bytes.fromhex("01 44 58 4C 22")
RETURN_DELAY = 0  # set up as recommended; 250 when new
REVERSE, TIME_BASED = 0x01, 0x04  # bits of Drive Mode
PROTOCOL = 2
GOAL_ONLY = [GOAL]  # what a write of goals touches: nothing else of the loop has changed
ACCELERATION_S = 0.064  # in which a count of acceleration makes a count of velocity
LARGEST_OFFSET_IN_POSITION_MODE = 1024


class VirtualServo:
    """One servo: control table, its share of the firmware, its motor in the world.

    Args:
        model: Its model.
        index: Its place in the world and in the firmware bank.
        servo_id: Dynamixel id.
        baud_code: Value of the baud rate register.
        world: The motors.
        firmware: The control loops.
        assumed: What is assumed about it.

    Attributes:
        table: Its registers.
        protection: What it protects itself against.
        heard_ns: When its watchdog last heard an instruction packet.
    """

    def __init__(
        self,
        model: ServoModel,
        index: int,
        servo_id: int,
        baud_code: int,
        world: MotorWorld,
        firmware: FirmwareBank,
        assumed: ServoAssumed = SERVO_ASSUMED,
    ) -> None:
        self.table = ControlTable(model, servo_id, baud_code, RETURN_DELAY, assumed)
        self._assumed = assumed
        self.protection = Protection(index, assumed, model.ratings)
        self._index = index
        self._world = world
        self._firmware = firmware
        self._loop = firmware.columns  # views: what is written here is what the loop runs on
        self._loop["current_unit"][index] = model.current_unit_a
        self._rebase_ticks = 0  # turns taken off the continuous encoder by reboot or Clear
        self.heard_ns = 0
        self._awake_ns = 0  # deaf before: it is starting
        self._registered: tuple[int, bytes] | None = None
        self._timed_goal = (
            math.nan,
            math.nan,
        )  # goals that the time-based profile was worked out for
        self._timed = 0.0, 0.0  # velocity and acceleration of it [counts]
        self._goal_is_here()
        self._sync_firmware()

    @property
    def servo_id(self) -> int:
        """Dynamixel id."""
        return self.table.values["id"]

    @property
    def shadow_id(self) -> int:
        """Secondary id, above 252 when there is none."""
        return self.table.values["secondary_id"]

    @property
    def alert(self) -> bool:
        """Whether a hardware error is latched."""
        return self.table.values["hardware_error_status"] != 0

    @property
    def return_delay_ns(self) -> int:
        """How long it waits before it answers."""
        return round(self.table.values["return_delay_time"] * RETURN_DELAY_UNIT_S * 1e9)

    def identity(self) -> bytes:
        """Return what a ping is answered with: model number and firmware version."""
        model = self.table.get("model_number").to_bytes(2, "little")
        return model + bytes([self.table.get("firmware_version")])

    def answers(self, instruction: int) -> bool:
        """Whether the status return level lets this instruction be answered."""
        level = self.table.get("status_return_level")
        if instruction == Instruction.PING:
            return True
        return level >= (1 if instruction == Instruction.READ else 2)

    # Time.

    def check(self, t_ns: int, motors: MotorReadings) -> None:
        """Look after the watchdog and the protections, with the motors as they are now."""
        units, torque = self.table.values["bus_watchdog"], self._torque
        if units > 0 and torque and t_ns - self.heard_ns > units * WATCHDOG_UNIT_S * 1e9:
            self.table.set("bus_watchdog", -1)
            self._stop_motor()
        error = self.protection.errors(self.table.values, t_ns, motors, torque=torque)
        if error:
            latched = self.table.get("hardware_error_status") | error
            self.table.set("hardware_error_status", latched)
            if error & self.table.get("shutdown"):
                self._set_torque(on=False)

    def _stop_motor(self) -> None:
        """The watchdog tripped: stop where it is (e-manual: profile 0) and take no more goals."""
        self.table.set("profile_velocity", 0)
        self.table.set("profile_acceleration", 0)
        self._sync_firmware()
        self._loop["trajectory"][self._index] = self._loop["goal_position"][self._index] = (
            self._shaft()
        )
        self._loop["stopped"][self._index] = True

    # Instructions.

    def obey(
        self, instruction: int, parameters: bytes, t_ns: int, *, broadcast: bool
    ) -> tuple[int, bytes]:
        """Do one instruction; return error number and data of the answer."""
        address, data = int.from_bytes(parameters[:2], "little"), parameters[2:]
        match instruction:
            case Instruction.PING:
                return 0, self.identity()
            case Instruction.READ if len(data) == 2:
                return self.read(address, int.from_bytes(data, "little"), t_ns)
            case Instruction.WRITE if data:
                return int(self.write(address, data, t_ns)), b""
            case Instruction.REG_WRITE if data:
                return int(self._register_write(address, data)), b""
            case Instruction.READ | Instruction.WRITE | Instruction.REG_WRITE:
                return StatusError.DATA_LENGTH, b""
            case Instruction.ACTION:
                return int(self._action(t_ns)), b""
            case Instruction.REBOOT:
                self.restart(t_ns)
                return 0, b""
            case Instruction.CLEAR:
                return int(self._clear(parameters)), b""
            case Instruction.FACTORY_RESET:
                return int(self._factory_reset(parameters, t_ns, broadcast)), b""
            case _:
                return StatusError.INSTRUCTION, b""

    def write_as_shadow(self, address: int, data: bytes, t_ns: int) -> None:
        """Write because the secondary id was meant: RAM only, never answered."""
        if address >= RAM_FROM and data:
            self.write(address, data, t_ns)

    def read(
        self, address: int, length: int, t_ns: int, motors: MotorReadings | None = None
    ) -> tuple[int, bytes]:
        """Return error number and bytes; measured registers are taken from the world now.

        Args:
            address: First byte.
            length: How many.
            t_ns: When it is asked.
            motors: What the world's sensors give now, None to ask them.
        """
        if self.table.may_show_measured(address, length):
            self._measure(t_ns, self._world.motors() if motors is None else motors)
        data = self.table.read(address, length)
        return (int(data), b"") if isinstance(data, StatusError) else (0, data)

    def write(self, address: int, data: bytes, t_ns: int) -> StatusError:
        """Write registers if the rules allow it; what depends on them follows."""
        error = self.table.check_write(address, data)
        if error is not StatusError.NONE:
            return error
        mode_before, torque_before = self.table.values["operating_mode"], self._torque
        touched = self.table.write(address, data)
        if touched == GOAL_ONLY:
            self._sync_goal()
            return StatusError.NONE
        if "operating_mode" in touched and self.table.get("operating_mode") != mode_before:
            self._changed_mode()
        if "torque_enable" in touched:
            wanted = self.table.get("torque_enable") == 1
            if wanted and self._shut_down:
                self.table.set("torque_enable", 0)
            elif wanted != torque_before:
                self._set_torque(on=wanted)
        if "bus_watchdog" in touched:
            self._loop["stopped"][self._index] = False
            self.heard_ns = t_ns
        self._sync_firmware()
        return StatusError.NONE

    def _register_write(self, address: int, data: bytes) -> StatusError:
        error = self.table.check_write(address, data)
        if error is StatusError.NONE:
            self._registered = (address, data)
            self.table.set("registered_instruction", 1)
        return error

    def _action(self, t_ns: int) -> StatusError:
        if self._registered is None:
            return StatusError.RESULT_FAIL
        address, data = self._registered
        self._registered = None
        self.table.set("registered_instruction", 0)
        return self.write(address, data, t_ns)

    def understands(self, baud_code: int | None, t_ns: int) -> bool:
        """Whether it has started and understands what is on the wire."""
        values = self.table.values
        speaks = self.awake(t_ns) and values["protocol_type"] == PROTOCOL
        return speaks and values["baud_rate"] == baud_code

    def awake(self, t_ns: int) -> bool:
        """Whether it has started."""
        return t_ns >= self._awake_ns

    def restart(self, t_ns: int) -> None:
        """Begin as after power-up: RAM, turns and torque are lost, EEPROM is kept; deaf for a while."""
        self._awake_ns = t_ns + round(self._assumed.restart_s * 1e9)
        self.table.changes += 1  # it hears nothing meanwhile
        self._set_torque(on=False)
        self.table.reset_ram()
        self._registered = None
        self.protection.restart()
        self._into_one_turn()
        self._goal_is_here()
        self._sync_firmware()

    def _clear(self, parameters: bytes) -> StatusError:
        if parameters != CLEAR_MULTI_TURN:
            return StatusError.DATA_RANGE
        if abs(self._world.motors().rate_rad_s[self._index]) > self._moving_rad_s:
            return StatusError.RESULT_FAIL
        self._into_one_turn()
        self._goal_is_here()
        self._loop["trajectory"][self._index] = self._shaft()
        self._sync_firmware()
        return StatusError.NONE

    def _factory_reset(self, parameters: bytes, t_ns: int, broadcast: bool) -> StatusError:
        if len(parameters) != 1 or parameters[0] not in {0xFF, 0x01, 0x02}:
            return StatusError.DATA_RANGE
        if broadcast and parameters[0] == 0xFF:
            return StatusError.RESULT_FAIL  # refused from firmware 42 on
        keep_id, keep_baud = parameters[0] in {0x01, 0x02}, parameters[0] == 0x02
        servo_id = self.servo_id if keep_id else 1
        baud = self.table.get("baud_rate") if keep_baud else 1
        changes = self.table.changes
        self.table = ControlTable(self.table.model, servo_id, baud, 250, self._assumed)
        self.table.changes += changes
        self.restart(t_ns)
        return StatusError.NONE

    # State.

    @property
    def _torque(self) -> bool:
        return self._firmware.torque(self._index)

    @property
    def _shut_down(self) -> bool:
        return bool(self.table.get("hardware_error_status") & self.table.get("shutdown"))

    @property
    def _sense(self) -> int:
        """-1 where Drive Mode reverses every signed register but the homing offset."""
        return -1 if self.table.values["drive_mode"] & REVERSE else 1

    def _shaft(self) -> float:
        """The continuous encoder in the world's own sense, before rounding [ticks]."""
        return float(self._world.motors().ticks[self._index])

    def _encoder(self) -> float:
        """The same in the sense that Drive Mode asks for."""
        return self._sense * self._shaft()

    @property
    def _offset(self) -> int:
        """Present position minus what the encoder counts: homing offset, and turns forgotten."""
        offset = self.table.values["homing_offset"]
        if self.table.values["operating_mode"] == POSITION:
            limit = LARGEST_OFFSET_IN_POSITION_MODE
            offset = max(-limit, min(limit, offset))
        return offset - self._rebase_ticks

    def _into_one_turn(self) -> None:
        self._rebase_ticks = int(np.floor(self._encoder() / TICKS_PER_TURN)) * TICKS_PER_TURN
        self.table.changes += 1  # as if its homing offset did

    def _set_torque(self, *, on: bool) -> None:
        self.table.set("torque_enable", int(on))
        if on:
            if self.table.get("operating_mode") == POSITION:
                self._into_one_turn()
            if self._assumed.goal_at_torque_on == "here":
                self._goal_is_here()
            self._timed_goal = math.nan, math.nan
            self._firmware.restart(self._index, self._shaft())
        self._loop["torque"][self._index], self._loop["stopped"][self._index] = on, False

    def _changed_mode(self) -> None:
        mode = self.table.get("operating_mode")
        if self._assumed.gains_at_mode_change == "reset":
            # e-manual: gains of that mode; the same ones in all modes are assumed
            for register in (*self._between(*GAINS), *self._between(*PROFILE)):
                self.table.set(register.name, register.initial or 0)
        for goal, limit in (("goal_pwm", "pwm_limit"), ("goal_current", "current_limit")):
            if goal in self.table:
                self.table.set(goal, self.table.get(limit))
        if mode == POSITION:
            self._into_one_turn()
        self._goal_is_here()
        self._firmware.restart(self._index, self._shaft())

    def _between(self, first: str, last: str) -> list[Register]:
        return self.table.model.table.between(first, last)

    def _goal_is_here(self) -> None:
        """A servo that starts, or changes its mode, takes its position for its goal."""
        self.table.set("goal_position", round(self._encoder()) + self._offset)

    def _sync_firmware(self) -> None:
        """Copy the registers the control loop works from."""
        loop, i, get, sense = self._loop, self._index, self.table.get, self._sense
        for name in COPIED:
            loop[name][i] = get(name)
        for name in TURNED:
            if name in self.table:
                loop[name][i] = sense * get(name)
        self._sync_goal()

    def _sync_goal(self) -> None:
        """Copy the goal, and where times are given instead of speeds, what follows from it."""
        loop, i, values = self._loop, self._index, self.table.values
        if not self._torque:
            loop["goal_position"][i] = loop["trajectory"][i] = self._shaft()
        elif not loop["stopped"][i]:
            loop["goal_position"][i] = self._sense * (values["goal_position"] - self._offset)
        if values["drive_mode"] & TIME_BASED:
            self._plan_by_time()

    def _plan_by_time(self) -> None:
        """Give the loop the profile that takes the times in both profile registers [ms]."""
        loop, i = self._loop, self._index
        goals = float(loop["goal_position"][i]), float(loop["goal_velocity"][i])
        if goals != self._timed_goal:
            self._timed_goal = goals
            whole_s = 1e-3 * self.table.get("profile_velocity")
            ramp_s = 1e-3 * self.table.get("profile_acceleration")
            if loop["operating_mode"][i] == VELOCITY:
                speed, gain = 0.0, abs(loop["goal_velocity"][i] - loop["ramp_velocity"][i])
            else:
                ramp_s = min(ramp_s, whole_s / 2)
                cruise_s = whole_s - ramp_s
                ticks = abs(loop["goal_position"][i] - loop["trajectory"][i])
                gain = ticks * TICK_RAD / VELOCITY_UNIT_RAD_S / cruise_s if cruise_s else 0.0
                speed = gain
            self._timed = speed, gain * ACCELERATION_S / ramp_s if ramp_s else 0.0
        loop["profile_velocity"][i], loop["profile_acceleration"][i] = self._timed

    @property
    def _moving_rad_s(self) -> float:
        """A shaft that is faster is moving."""
        return self.table.values["moving_threshold"] * VELOCITY_UNIT_RAD_S

    @property
    def plain_goal(self) -> tuple[int, int] | None:
        """Sense and offset that turn a goal into its loop's; None where a goal changes the profile, too."""
        return None if self.table.values["drive_mode"] & TIME_BASED else (self._sense, self._offset)

    def measured_settings(self) -> tuple[float, ...]:
        """Return what the registers say of its measurements: a row for ``measured_kernel``."""
        model, alert = self.table.model, ALERT if self.alert else 0
        unit_a = model.current_unit_a if model.measures_current else 0.0
        return self._sense, self._offset, self._moving_rad_s, unit_a, alert

    def _measure(self, t_ns: int, motors: MotorReadings) -> None:
        """Fill the registers of what is measured."""
        values = np.empty(len(measured_run(self.table.model).sizes))
        settings = np.array(self.measured_settings())
        servos, i = self._firmware.servos, self._index
        measured_kernel.measure(servos, i, settings, *motors, realtime_tick(t_ns), values)
        self.table.put_measured(*map(int, values.tolist()))


def realtime_tick(t_ns: int) -> int:
    """Return the register of that name: milliseconds, in fifteen bits."""
    return (t_ns // 1_000_000) % 32768
