"""Scenario files: what they say, what is wrong with them, and that the same one gives the same bytes."""

import math
from pathlib import Path

import pytest

from model.errors import ConfigError
from robot.config.robot_file import load_robot
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.faults.kinds import KINDS, MaskChange, Overheating, SilentServo
from sim_hw.faults.reference import COMMON, common_settings, kinds_of_fault, tables
from sim_hw.faults.scenario import Scenario, load_scenario, parse_scenario
from sim_hw.faults.time import ScenarioTime

IDS = (1, 2, 3, 4, 5, 6)
EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("faults_*.toml"))
# What a kind cannot do without.
NEEDED = {
    "servo": "servo = 3",
    "transducers": "transducers = [1, 2]",
    "transducer": "transducer = 4",
    "step_s": "step_s = -1.5",
    "percent": "percent = 2",
}


def test_an_empty_file_is_sound_devices() -> None:
    assert parse_scenario("", IDS) == Scenario()


def test_what_a_file_says() -> None:
    text = """
        seed = 9
        begins = "torque"
        [servo]
        reserved = "error"
        old_firmware = [2]
        [force_unit]
        battery = 5
        [adapter]
        latency_timer_s = 0.016
        [[fault]]
        kind = "silent_servo"
        servo = 3
        start_s = 2
        duration_s = 0.5
        [[fault]]
        kind = "mask_change"
        transducers = [2, 4]
        """
    read = parse_scenario(text, IDS)
    assert (read.course.seed, read.course.begins) == (9, "torque")
    assert (read.servo.reserved, read.servo.old_firmware) == ("error", (2,))
    assert (read.force_unit.battery, read.adapter.latency_timer_s) == (5, 0.016)
    assert read.faults == (
        SilentServo(servo=3, start_s=2.0, duration_s=0.5),
        MaskChange(transducers=(2, 4), start_s=0.0, duration_s=math.inf),
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sed = 1", "sed: is not a known key; did you mean 'seed'?"),
        ("[servos]", "servos: is not a known key; did you mean 'servo'?"),
        ("[servo]\nreservd = 1", "servo.reservd: is not a known key; did you mean 'reserved'?"),
        ("servo = 3", "servo: must be a table, not 3"),
        ("[fault]", "fault: must be [[fault]] tables, in double brackets"),
        ("fault = [3]", "fault[0]: must be a table, not 3"),
        ("[[fault]]", "fault[0].kind: is missing"),
        ("[[fault]]\nkind = 3", "fault[0].kind: must be a text, not 3"),
        ("[[fault]]\nkind = 'bitflip'", "fault[0].kind: 'bitflip' is not a known kind of fault; did"),
        ("[[fault]]\nkind = 'overload'", "fault[0].servo: is missing; add it to the scenario"),
        ("[[fault]]\nkind = 'echo'\nservo = 1", "fault[0].servo: is not a known key"),
        ("[[fault]]\nkind = 'echo'\n[[fault]]\nkind = 'echo'\nrate = 2", "fault[1].rate: must be from"),
        ("[[fault]]\nkind = 'echo'\nstart_s = -1", "fault[0].start_s: must be from 0 to inf, not -1"),
        ("[[fault]]\nkind = 'echo'\nstart_s = nan", "fault[0].start_s: must be from 0 to inf, not nan"),
        ("[[fault]]\nkind = 'echo'\nstart_s = '1'", "fault[0].start_s: must be a number, not '1'"),
        ("[[fault]]\nkind = 'echo'\ncount = 1.5", "fault[0].count: must be a whole number, not 1.5"),
        ("[[fault]]\nkind = 'echo'\ncount = true", "fault[0].count: must be a whole number, not True"),
        ("[[fault]]\nkind = 'silent_stop'\nneeds_start = 1", "needs_start: must be true or false, not 1"),
        ("[[fault]]\nkind = 'low_battery'\nled = 'blue'", "fault[0].led: must be one of red, orange, off"),
        ("[[fault]]\nkind = 'mask_change'\ntransducers = 2", "must be a list of whole numbers, not 2"),
        ("[[fault]]\nkind = 'mask_change'\ntransducers = [7]", "transducers[0]: must be from 1 to 6"),
        ("[[fault]]\nkind = 'overload'\nservo = 7", "7 is no servo of this robot; it has 1, 2, 3, 4, 5, 6"),
        ("[servo]\nold_firmware = [8]", "servo.old_firmware: 8 is no servo of this robot"),
        ("[servo]\nold_firmware = [2]\n[[fault]]\nkind = 'overload'\nservo = 2", "has old firmware"),
        ("[force_unit]\nempty_line = 'ä'", "force_unit.empty_line: must be plain ASCII"),
        ("begins = 'now'", "begins: must be one of power, torque, not 'now'"),
        ("seed =", "scenario: is not valid TOML"),
    ],
)  # fmt: skip
def test_a_mistake_is_named(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_scenario(text, IDS)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.toml: the scenario cannot be read: No such file"):
        load_scenario(tmp_path / "none.toml", IDS)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="it is not UTF-8 text"):
        load_scenario(binary, IDS)


# When faults are on.


def test_times_count_from_power_or_from_torque() -> None:
    fault = Overheating(servo=1, start_s=1.0, duration_s=0.5)
    power, torque = ScenarioTime("power"), ScenarioTime("torque")
    for time in (power, torque):
        time.look(100, torque=False)
        time.look(1_000, torque=True)
    for time, zero_ns in ((power, 100), (torque, 1_000)):
        start_ns, end_ns = zero_ns + 1_000_000_000, zero_ns + 1_500_000_000
        assert [time.active(fault, t) for t in (start_ns - 1, start_ns)] == [False, True]
        assert [time.active(fault, t) for t in (end_ns - 1, end_ns)] == [True, False]
        assert time.changes([fault], 0, 2**62) == [start_ns, end_ns]
    waiting = ScenarioTime("torque")
    waiting.look(5, torque=False)
    assert not waiting.active(Overheating(servo=1), 10**12)


# The reference that `bigant sim faults` prints, and the examples.


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_can_be_had_with_its_defaults(kind: str) -> None:
    described = next(k for k in kinds_of_fault() if k.kind == kind)
    lines = [NEEDED[s.name] for s in described.settings if s.needed]
    (fault,) = parse_scenario("\n".join(["[[fault]]", f'kind = "{kind}"', *lines]), IDS).faults
    assert type(fault) is KINDS[kind]
    assert described.chance == hasattr(fault, "rate")
    assert described.acts_on.split(":")[0] in {"servo bus", "servo", "plant", "force unit"}


def test_the_reference_leaves_nothing_unsaid() -> None:
    kinds = kinds_of_fault()
    assert [k.kind for k in kinds] == list(KINDS)
    assert all(k.text for k in kinds)
    settings = [*common_settings(), *(s for k in kinds for s in k.settings)]
    settings += [s for table in tables() for s in table.settings]
    assert not [s.name for s in settings if not s.text or not s.allowed]
    units = {s.name: s.unit for s in settings}
    assert tuple(s.name for s in common_settings()) == COMMON
    assert [units[name] for name in ("start_s", "rate", "count")] == ["s", "probability", ""]
    assert units["temperature_c"] == "degC"
    assert units["torque_n_m"] == "N m"
    assert units["overload_current_a"] == "A"
    assert units["piece_bytes"] == "bytes"


def uncommented(text: str) -> str:
    """The example with everything that is only offered switched on."""
    shown, offered = text.split("# Also to be had", 1)
    lines = [line.removeprefix("#").removeprefix(" ") for line in offered.splitlines()[1:]]
    return "\n".join([shown, *lines])


def test_the_examples_show_every_kind_of_fault() -> None:
    assert [path.name for path in EXAMPLES] == ["faults_force.toml", "faults_servo.toml"]
    seen = set()
    for path in EXAMPLES:
        assert load_scenario(path, IDS).faults
        seen |= {type(f) for f in parse_scenario(uncommented(path.read_text("utf-8")), IDS).faults}
    assert seen == set(KINDS.values())


# Determinism of a whole robot in memory.

BOTH = """
seed = {seed}
[adapter]
latency_timer_s = 0.001
[[fault]]
kind = "bit_flip"
start_s = 2.5
rate = 0.02
[[fault]]
kind = "foreign_reply"
start_s = 2.5
rate = 0.02
[[fault]]
kind = "late_reply"
start_s = 2.5
delay_s = 0.002
rate = 0.02
[[fault]]
kind = "packet_loss"
rate = 0.1
[[fault]]
kind = "reordered_packet"
rate = 0.1
[[fault]]
kind = "split_console"
"""


def bytes_of_a_session(seed: int) -> tuple[bytes, list[object]]:
    """What passes the servo port while the real drivers connect and read, and what they make of it."""
    config = load_robot()
    scenario = parse_scenario(BOTH.format(seed=seed), IDS)
    rig = open_in_memory(config, VirtualSettings(seed=3, armed=False, scenario=scenario))
    heard = bytearray()
    port = rig.bus._port
    note = port.note

    def listen(direction: str, data: bytes) -> None:
        heard.extend(direction.encode() + data)
        note(direction, data)

    port.note = listen  # type: ignore[method-assign]
    results: list[object] = []
    for _ in range(120):
        rig.clock.sleep_until_ns(rig.clock.now_ns() + 10_000_000)
        seen = rig.read()
        results.append((seen.servos.t_ns, seen.servos.valid.tolist(), len(seen.faults)))
        results.append([(r.t_ns, r.sequence, r.counts.tolist()) for r in seen.forces])
    rig.close()
    return bytes(heard), results


def test_the_same_scenario_gives_the_same_bytes() -> None:
    first, again, other = (bytes_of_a_session(seed) for seed in (1, 1, 2))
    assert len(first[0]) > 10_000
    assert first == again
    assert first != other
