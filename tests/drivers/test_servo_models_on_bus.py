"""Each servo known here, virtual, behind the driver and the vendor's SDK; several models on one bus."""

import math
from dataclasses import replace

import dynamixel_sdk
import numpy as np
import pytest

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106, SERVO_MODELS
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.frames import StatusError
from drivers.dynamixel.image import read_image
from drivers.dynamixel.joints import joint_state
from drivers.dynamixel.registers import HardwareError
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import TICK_RAD
from drivers.dynamixel.watchdog import prove_watchdog
from model.errors import BusError
from model.values.legs import JointCommand
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from tests.drivers.test_servo_models import bus_settings
from tests.sim_hw.motors import SimpleMotors

BAUD = 1_000_000
XL330, XL430 = MODEL_BY_NAME["XL330-M288"], MODEL_BY_NAME["XL430-W250"]
XM430, XH540 = MODEL_BY_NAME["XM430-W350"], MODEL_BY_NAME["XH540-V150"]
each = pytest.mark.parametrize("model", SERVO_MODELS, ids=lambda model: model.name)


class ModelBench:
    """Virtual servos of some models, and a bus whose settings may say other ones."""

    def __init__(self, *models: ServoModel, believed: tuple[ServoModel, ...] = ()) -> None:
        count = len(models)
        firmware, self.clock = FirmwareBank(count), VirtualClock(1_000_000_000)
        self.motors = SimpleMotors(firmware, count)
        self.motors.volts = np.array([model.ratings.voltage_v for model in models])
        self.ids = tuple(range(1, count + 1))
        self.servos = VirtualServoBus(self.motors, firmware, self.ids, BAUD, models=models)
        self.sent: list[bytes] = []
        self.received: list[bytes] = []
        self.settings = bus_settings(*(believed or models))
        self.bus = ServoBus(self.port(), self.settings)

    def port(self) -> MemoryPort:
        port = MemoryPort(self.servos, self.clock, BAUD)
        port.tap = lambda way, data, _: (self.sent if way == "tx" else self.received).append(data)
        return port

    def arm(self) -> None:
        self.bus.connect()
        self.bus.configure()
        self.bus.torque_on()

    def write(self, servo: int, name: str, value: int) -> StatusError:
        one = self.servos.servos[servo]
        register = one.table.model.table[name]
        return one.write(register.address, register.encode(value), self.clock.now_ns())


@each
def test_each_model_is_connected_turned_and_stopped_by_its_watchdog(model: ServoModel) -> None:
    bench = ModelBench(model, model)
    report = bench.bus.connect()
    assert [servo.model for servo in report.servos] == [model.number] * 2
    said = [words for words in report.warnings if "measures no current" in words]
    assert len(said) == (0 if model.measures_current else 1)
    bench.bus.configure()
    bench.bus.torque_on()
    for _ in range(50):
        goal = np.full(2, 0.2)
        bench.bus.write_goals(JointCommand(bench.clock.now_ns(), goal, np.zeros(2), torque=True))
        bench.clock.advance(20_000_000)
        readings = bench.bus.read()
    state = joint_state(readings, bench.settings)
    assert readings.valid.all()
    np.testing.assert_allclose(state.angle_rad, 0.2, atol=0.03)
    np.testing.assert_allclose(state.voltage_v, model.ratings.voltage_v, atol=0.05)
    assert np.isfinite(state.current_a).all() == model.measures_current
    assert bench.bus.torque_off()
    proof = prove_watchdog(bench.bus)
    assert proof.torque_off
    assert not proof.asleep


def test_the_loop_asks_an_xl330_for_the_same_23_bytes() -> None:
    """The request and the answer, byte for byte: 5.0 V, 30 degC, 120 mA backward, at 2048."""
    bench = ModelBench(XL330)
    bench.bus.connect()
    bench.motors.currents[:] = -0.120
    bench.sent.clear()
    bench.received.clear()
    state = joint_state(bench.bus.read(), bench.settings)
    assert bench.sent[0] == bytes.fromhex("FF FF FD 00 FE 08 00 82 7C 00 17 00 01 C2 E7")
    answer = b"".join(bench.received)
    data = "00 00 88 FF 00 00 00 00 00 08 00 00 00 00 00 00 00 08 00 00 32 00 1E"
    assert answer[:9] == bytes.fromhex("FF FF FD 00 01 1B 00 55 00")
    assert answer[9:32] == bytes.fromhex(data)
    assert state.current_a == pytest.approx(-0.120)
    assert state.voltage_v == pytest.approx(5.0)
    assert state.temperature_c == pytest.approx(30)


def test_currents_of_a_mixed_bus_by_each_servos_unit() -> None:
    bench = ModelBench(MX_106, XM430, XL330, XL430, XH540)
    bench.bus.connect()
    bench.motors.currents[:] = 0.5
    readings = bench.bus.read()
    assert readings.current_counts.tolist() == [149, 186, 500, 0, 186]
    state = joint_state(readings, bench.settings)
    signs = bench.settings.signs
    np.testing.assert_allclose((signs * state.current_a)[[0, 1, 2, 4]], 0.5, atol=0.002)
    assert math.isnan(state.current_a[3])
    assert state.valid.all()


def test_the_load_of_an_xl430_is_its_output_in_tenths_of_a_per_cent() -> None:
    bench = ModelBench(XL430)
    bench.arm()
    bench.motors.hold = True
    goal = np.array([200 * TICK_RAD])
    bench.bus.write_goals(JointCommand(bench.clock.now_ns(), goal, np.zeros(1), torque=True))
    bench.clock.advance(20_000_000)
    readings = bench.bus.read()
    duty, load = int(readings.duty_counts[0]), int(readings.current_counts[0])
    assert duty > 100
    assert load == round(duty / 885 * 1000)


@pytest.mark.parametrize(
    ("there", "words"),
    [
        (
            XL430,
            r"L1 \(id 2\) is an XL430-W250 and the robot file says MX-106\(2.0\): set model in ",
        ),
        (
            9999,
            r"L1 \(id 2\) is model 9999, which is not known here; check that the id is not that ",
        ),
        (310, r"L1 \(id 2\) has protocol 1.0 firmware.*put the MX-64\(2.0\) firmware on it"),
    ],
)
def test_another_model_than_the_robot_file_says_is_named(
    there: ServoModel | int, words: str
) -> None:
    if isinstance(there, int):
        bench = ModelBench(MX_106, MX_106)
        bench.servos.servos[1].table.set("model_number", there)
    else:
        bench = ModelBench(MX_106, there, believed=(MX_106, MX_106))
    with pytest.raises(BusError, match=words) as caught:
        bench.bus.connect()
    assert caught.value.ids == (2,)
    assert caught.value.register == "model_number"


def test_a_virtual_servo_knows_the_registers_and_modes_of_its_model_only() -> None:
    bench = ModelBench(MX_106, XL430, XL330)
    assert bench.write(0, "operating_mode", 0) is StatusError.NONE
    assert bench.write(1, "operating_mode", 0) is StatusError.DATA_RANGE, "it has no current mode"
    assert bench.write(2, "operating_mode", 5) is StatusError.NONE
    limit = MX_106.table["current_limit"]
    xl430 = bench.servos.servos[1]
    assert xl430.write(limit.address, limit.encode(100), 0) is StatusError.ACCESS
    assert bench.write(2, "current_limit", 1751) is StatusError.DATA_RANGE
    assert bench.write(2, "pwm_slope", 0) is StatusError.DATA_RANGE
    assert bench.write(2, "baud_rate", 7) is StatusError.DATA_RANGE, "4 Mbps at most"
    assert bench.servos.servos[2].read(578, 2, 0)[0] == StatusError.DATA_LENGTH, "behind its end"
    gains = [servo.table.get("position_p_gain") for servo in bench.servos.servos]
    assert gains == [850, 640, 400]
    assert [servo.table.get("shutdown") for servo in bench.servos.servos] == [0x34, 0x34, 0x35]


def test_an_xl330_on_12_volt_shuts_down_and_says_why() -> None:
    bench = ModelBench(XL330)
    bench.arm()
    bench.motors.volts[:] = 12.0
    bench.clock.advance(20_000_000)
    bench.servos.poll(bench.clock.now_ns())
    assert bench.servos.servos[0].table.get("hardware_error_status") == HardwareError.INPUT_VOLTAGE
    assert bench.servos.servos[0].table.get("torque_enable") == 0
    bench = ModelBench(XL330)
    bench.motors.volts[:] = 12.0
    bench.servos.poll(bench.clock.now_ns())
    with pytest.raises(BusError, match=r"has shut down \(input voltage\)"):
        bench.bus.connect()


@each
def test_an_image_holds_what_the_model_keeps(model: ServoModel) -> None:
    bench = ModelBench(model)
    bench.bus.open()
    image = read_image(bench.bus.servos()[0])
    assert image.model == model.number
    assert set(image.values) == {*model.table.kept, *model.table.gains}
    assert image.values["velocity_limit"] == model.table["velocity_limit"].initial
    assert ("current_limit" in image.values) is model.measures_current


def test_without_its_model_a_servo_is_asked_for_what_all_have() -> None:
    bench = ModelBench(XL430)
    bench.bus.open()
    servo: CheckedServo = bench.bus.servos()[0]
    unknown = CheckedServo(servo.packets, "servo", 1)
    assert unknown.read("position_p_gain") == 640
    assert "current_limit" not in unknown.table
    assert "current_limit" not in read_image(unknown).values


@pytest.mark.parametrize("model", [XL330, XL430, XH540], ids=lambda model: model.name)
def test_the_vendors_sdk_talks_to_other_models(model: ServoModel) -> None:
    bench = ModelBench(model, model)
    port, packets = bench.port(), dynamixel_sdk.PacketHandler(2.0)
    port.openPort()
    assert packets.ping(port, 1) == (model.number, 0, 0)
    assert packets.write1ByteTxRx(port, 1, 11, 4) == (0, 0)
    assert packets.write1ByteTxRx(port, 1, 64, 1) == (0, 0)
    assert packets.write4ByteTxRx(port, 1, 116, 2100) == (0, 0)
    read = dynamixel_sdk.GroupSyncRead(port, packets, 124, 23)
    for number in bench.ids:
        read.addParam(number)
    assert read.txRxPacket() == 0
    assert [read.getData(i, 144, 2) for i in bench.ids] == [round(10 * model.ratings.voltage_v)] * 2
    limit = packets.read2ByteTxRx(port, 2, 38)
    assert (limit[0] == model.table["current_limit"].initial) if model.measures_current else True


def test_settings_say_whose_current_is_measured() -> None:
    settings = bus_settings(MX_106, XL430)
    assert settings.measures_current.tolist() == [True, False]
    swapped = replace(settings, models=(XL430, MX_106))
    assert swapped.measures_current.tolist() == [False, True]
