"""A scenario: what goes wrong with the virtual hardware, and when. Read from a TOML file.

Keys: ``seed``, ``begins`` (``power``: when the devices are first used; ``torque``: when a servo's torque is
first switched on), the tables ``servo``, ``force_unit``, ``adapter`` and ``imu`` of ``sim_hw.assumed``, and
any number of ``[[fault]]`` tables with a ``kind`` of ``sim_hw.faults.kinds``. See
examples/faults_servo.toml.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from model.errors import ConfigError
from model.parameters.toml_table import parse_toml
from record.toml_file import reading
from sim_hw.assumed import AdapterAssumed, ImuAssumed, ServoAssumed, WnetAssumed
from sim_hw.faults.kinds import KINDS, ScenarioFault
from sim_hw.typed_table import among, read_table, suggestion, within

TABLES = ("servo", "force_unit", "adapter", "imu", "fault")


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """How a scenario runs."""

    seed: int = within(
        0, 0, 2**32 - 1, "Of every chance in it; the same seed gives the same bytes."
    )
    begins: str = among("power", "torque", text="What its times count from.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A scenario.

    Attributes:
        course: Seed and beginning.
        servo: What is assumed about the servos.
        force_unit: What is assumed about the force-torque unit.
        adapter: The USB adapter of the servo bus.
        imu: The IMU; None where the scenario says nothing of one.
        faults: What goes wrong.
    """

    course: Course = field(default_factory=Course)
    servo: ServoAssumed = field(default_factory=ServoAssumed)
    force_unit: WnetAssumed = field(default_factory=WnetAssumed)
    adapter: AdapterAssumed = field(default_factory=AdapterAssumed)
    imu: ImuAssumed | None = None
    faults: tuple[ScenarioFault, ...] = ()


def load_scenario(path: Path, ids: Collection[int]) -> Scenario:
    """Read a scenario file.

    Args:
        path: The file.
        ids: Servos of the robot.

    Raises:
        ConfigError: It cannot be read, or something in it makes no sense; the key is named.
    """
    with reading(path, "the scenario") as text:
        return parse_scenario(text, ids)


def parse_scenario(text: str, ids: Collection[int]) -> Scenario:
    """Return the scenario that a TOML text describes; see ``load_scenario``."""
    data = parse_toml(text, "scenario")
    scenario = Scenario(
        course=read_table(Course, data, "", also=TABLES),
        servo=read_table(ServoAssumed, data.get("servo", {}), "servo"),
        force_unit=read_table(WnetAssumed, data.get("force_unit", {}), "force_unit"),
        adapter=read_table(AdapterAssumed, data.get("adapter", {}), "adapter"),
        imu=read_table(ImuAssumed, data["imu"], "imu") if "imu" in data else None,
        faults=_faults(data.get("fault", [])),
    )
    _check_ids(scenario, ids)
    return scenario


def _faults(tables: Any) -> tuple[ScenarioFault, ...]:
    if not isinstance(tables, list):
        raise ConfigError("fault", "must be [[fault]] tables, in double brackets")
    return tuple(_fault(table, f"fault[{i}]") for i, table in enumerate(tables))


def _fault(table: Any, path: str) -> ScenarioFault:
    if not isinstance(table, Mapping):
        raise ConfigError(path, f"must be a table, not {table!r}")
    if "kind" not in table:
        raise ConfigError(f"{path}.kind", "is missing; add it to the scenario")
    name = table["kind"]
    if not isinstance(name, str):
        raise ConfigError(f"{path}.kind", f"must be a text, not {name!r}")
    if name not in KINDS:
        hint = suggestion(name, tuple(KINDS))
        raise ConfigError(f"{path}.kind", f"{name!r} is not a known kind of fault; {hint}")
    return read_table(KINDS[name], table, path, also=("kind",))


def _check_ids(scenario: Scenario, ids: Collection[int]) -> None:
    servo = scenario.servo
    named = [("servo.old_firmware", servo_id) for servo_id in servo.old_firmware]
    named += [("servo.shares_id", servo_id) for servo_id in servo.shares_id]
    for i, fault in enumerate(scenario.faults):
        servo_id = getattr(fault, "servo", None)
        if servo_id is not None:
            named.append((f"fault[{i}].servo", servo_id))
            if servo_id in servo.old_firmware:
                raise ConfigError(f"fault[{i}].servo", f"{servo_id} has old firmware and no faults")
            if servo_id in servo.shares_id:
                raise ConfigError(f"fault[{i}].servo", f"{servo_id} has another one's id")
    for key, servo_id in named:
        if servo_id not in ids:
            known = ", ".join(str(i) for i in ids)
            raise ConfigError(key, f"{servo_id} is no servo of this robot; it has {known}")
