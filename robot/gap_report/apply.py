"""``bigant gap apply``: a diagnosis into a corrected robot file, and the gap measured again through it."""

from pathlib import Path

from gap.diagnosis.comparison.how_far import HowFar
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.catalogue import CATALOGUE, EFFECTS
from model.effects.correction import correction_of, keyless_of
from model.effects.machine import parse_machine
from model.effects.written import table_name
from model.errors import ConfigError, GapError
from model.parameters.tables import leg_table, parse_table, read_leg, read_leg_names
from record.whole_file import check_room, write_text
from robot.config.edit import Edited, check_edited, edit_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import Column, table_lines
from robot.control.effect_uses import USES
from robot.gap_report.answer import ReadDiagnosis, diagnosed_runs, read_diagnosis
from robot.gap_report.apply_machine import apply_to_machine
from robot.gap_report.legged import robot_text
from robot.gap_report.measured_again import (
    check_applicable,
    exit_code,
    measure_again,
    measured_json,
    measured_lines,
)
from robot.gap_report.trials import Runs, runs_of_diagnosis
from robot.gap_report.words import LEGGED_SIMULATORS
from robot.requests.gap import MUJOCO, GapApplyRequest

KEYS = (Column("", width=28), Column("", ".4g", 10), Column(""), Column("", ".4g"), Column(""))


def apply_diagnosis(request: GapApplyRequest) -> ExitCode:
    """Correct the robot file and measure again.

    Raises:
        RecordError: A file cannot be read or written.
        GapError: There is nothing to apply, or a robot file cannot hold it.
        ConfigError: The robot file cannot be used.
    """
    out = request.out
    if out.exists():  # it may be the file that the runs themselves name
        raise ConfigError("--out", f"{out} exists; choose another name")
    of = diagnosed_runs(request.diagnosis)
    if of.simulator not in LEGGED_SIMULATORS:
        return apply_to_machine(request, of)
    check_room(out, "--out", ".toml")
    diagnosis = read_diagnosis(request.diagnosis, CATALOGUE)
    check_applicable(diagnosis, anyway=request.anyway)
    robot = request.robot or of.robot
    runs = runs_of_diagnosis(of, robot) if of.trials else None
    text = _robot_text(diagnosis, runs, robot)
    top = parse_table(text)
    keyless = keyless_of(read_leg(top)) if top.has(leg_table(top.names())) else frozenset()
    correction = correction_of(diagnosis.causes, read_leg_names(top.table("legs")), keyless)
    edited = edit_robot(text, correction, request.diagnosis.name)
    check_edited(edited.text, text)
    write_text(out, edited.text)
    far = None if runs is None else _measured(edited.text, runs, diagnosis)
    if request.json:
        print_json(_as_json(out, diagnosis, edited, far))
    else:
        print("\n".join(_lines(out, diagnosis, edited, far)))
    return exit_code(diagnosis, far)


def _robot_text(diagnosis: ReadDiagnosis, runs: Runs | None, robot: Path | None) -> str:
    if robot is not None:
        return robot_text(robot)
    if runs is None:
        raise GapError(
            f"the runs of {diagnosis.path} are not where they were, so their robot file is not known; give "
            "it with --robot"
        )
    return runs.robot_text


def _measured(after: str, runs: Runs, diagnosis: ReadDiagnosis) -> HowFar:
    """Measure with both files; ``after`` is read from its text, as every command does."""
    if diagnosis.simulator == MUJOCO:
        from robot.virtual.twin_rollout import twin_simulator  # and with it MuJoCo

        old = runs.made_by(lambda own: twin_simulator(own[0].header.robot_text))
        return measure_again(runs, old, twin_simulator(after), diagnosis)
    return measure_again(runs, runs.simulator(), LeggedSimulator(parse_machine(after)), diagnosis)


def _lines(out: Path, diagnosis: ReadDiagnosis, edited: Edited, far: HowFar | None) -> list[str]:
    keys = [(e.key, e.before, "->", e.after, e.why) for e in edited.edits]
    lines = [f"written: {out}", *table_lines(KEYS, keys, "  ")]
    for one in edited.effects:
        named = EFFECTS[one.effect].named(one.values)
        numbers = ", ".join(f"{name} = {value:.4g}" for name, value in named.items()) or "a law"
        lines.append(f"  [{table_name(one.effect, one.joints)}]  {numbers}")
        lines.append(f"      drive, odom, replay: {USES[one.effect].value}")
    return [*lines, *measured_lines(out, diagnosis, far)]


def _as_json(
    out: Path, diagnosis: ReadDiagnosis, edited: Edited, far: HowFar | None
) -> dict[str, object]:
    effects = [
        {
            "effect": e.effect,
            "leg": "".join(e.joints),
            "parameters": EFFECTS[e.effect].named(e.values),
            "use": USES[e.effect].value,
        }
        for e in edited.effects
    ]
    gap = measured_json(diagnosis, far)
    return {"file": out, "keys": edited.edits, "effects": effects, "gap": gap}
