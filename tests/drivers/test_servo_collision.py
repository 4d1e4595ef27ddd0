"""Two servos with one id: both answer at once, and neither is understood."""

from drivers.dynamixel.frames import Frame
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.scan import id_is_shared
from tests.drivers.scripted_servos import Replies, ScriptedPort, ScriptedServos, Servo


def shared(servos: ScriptedServos) -> bool:
    port = ScriptedPort(servos.respond)
    return id_is_shared(ServoRequests(port), 1)


def test_one_servo_is_one() -> None:
    assert not shared(ScriptedServos(Servo(1), Servo(2)))


def test_answers_on_top_of_each_other() -> None:
    servos = ScriptedServos(Servo(1))

    def both(_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        other = data[:-4] + bytes([data[-4] ^ 0x21, data[-3], data[-2] ^ 0x18, data[-1]])
        return [(at_ns, bytes(a & b for a, b in zip(data, other, strict=True)))]

    servos.edit = both
    assert shared(servos)


def test_answers_one_after_the_other() -> None:
    servos = ScriptedServos(Servo(1))
    servos.edit = lambda _, __, at_ns, data: [(at_ns, data), (at_ns + 1_000_000, data)]
    assert shared(servos)


def test_one_damaged_answer_is_only_noise() -> None:
    servos = ScriptedServos(Servo(1))
    answered = 0

    def once(_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        nonlocal answered
        answered += 1
        return [(at_ns, data[:-1] + b"\x00" if answered == 2 else data)]

    servos.edit = once
    assert not shared(servos)


def test_a_slow_host_is_no_second_servo() -> None:
    """An answer that comes after its timeout is late, and not somebody else's."""
    servos = ScriptedServos(Servo(1))
    answered = 0

    def late_once(_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        nonlocal answered
        answered += 1
        return [(at_ns + (8_000_000 if answered == 1 else 0), data)]

    servos.edit = late_once
    assert not shared(servos)
