"""One cause that a machine can have in several forms: tried as one candidate, named once, at its price."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from gap.delegate import Without
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.diagnose import diagnose, diagnose_study
from gap.interfaces import Cause
from gap.search.candidates import candidates_of, families_of
from model.effects.catalogue import CATALOGUE
from model.errors import ConfigError
from robot.campaign.case import read_case
from robot.cli.main import run as command
from robot.console.json_output import json_text
from robot.gap_report.answer import read_diagnosis
from robot.virtual.file_twin import twin_effects
from tests.gap.toy import EFFECTS, Toy, toy_case, toy_references
from tests.gap.walks import simulator
from tests.soaked import THOROUGH

# a lag as another form of the delay, at the toy as it is
LATE = Toy(tuple(replace(one, form_of="delay") if one.name == "lag" else one for one in EFFECTS))
GIVES = ("servo_compliance", "servo_compliance_beyond_encoder")
# What healthy walks of 30 s show of both virtual robots.
STANDING = (
    Cause("servo_lag", (), (0.048,)),
    Cause("leg_flex", (), (4e-5, 4e-5)),
    Cause("coulomb_friction", (), ()),
)
SHORTENED = {"servo_compliance", "gear_backlash", *(one.effect for one in STANDING)}


def late(effect: str, size: float, seed: int = 3) -> Diagnosis:
    trials = toy_case([Cause(effect, (), (size,))] if size else [], seed=seed)
    return diagnose(trials, LATE, toy_references(seed))


@pytest.mark.parametrize("form", ["delay", "lag"])
def test_a_form_is_named_as_its_cause_and_said_to_be_that_form(form: str) -> None:
    d = late(form, 0.05)
    assert d.verdict is Verdict.EXPLAINED
    (one,) = d.causes
    assert (one.effect, one.form) == ("delay", form)
    assert one.cause == Cause(form, (), one.cause.values)
    assert one.cause.values[0] == pytest.approx(0.05, rel=0.1)
    assert ("lag" in one.words) == (form == "lag")
    assert not [rival for rival in d.rivals if rival.effect == "delay"], "no rival of itself"


def test_a_healthy_machine_has_no_form_of_any_cause() -> None:
    assert late("lag", 0.0).verdict is Verdict.NO_GAP


def test_the_forms_of_a_cause_share_its_name_and_pay_for_having_been_tried() -> None:
    listed = candidates_of(simulator())
    gives = [one for one in listed if one.effect.name in GIVES]
    assert {one.family[0] for one in gives} == {"servo_compliance"}
    assert len({one.key for one in gives}) == 2 * len({one.family for one in gives})
    assert all(one.price == math.log(2) for one in gives)
    forms = [one for one in listed if one.effect.family == "stiction"]
    assert {one.effect.name for one in forms} == {"stiction", "stick_slip"}
    plays = [one for one in listed if one.effect.family == "gear_backlash"]
    assert len({one.key for one in plays}) == 4 * len({one.family for one in plays})
    assert all(one.price == math.log(4) for one in plays)
    assert all(one.price == 0.0 for one in listed if one not in (*gives, *forms, *plays))
    effects = {effect.name: effect for effect in CATALOGUE}
    taken = families_of([Cause(GIVES[1], ("ML",), (0.01,))], effects)
    assert taken == {("servo_compliance", ("ML",))}


def test_a_catalogue_without_a_cause_is_without_all_its_forms() -> None:
    left = {effect.name for effect in Without(simulator(), ["servo_compliance"]).effects}
    assert not left & set(GIVES)


def test_a_virtual_robot_that_cannot_have_a_form_says_so() -> None:
    with pytest.raises(
        ConfigError, match=r"effects\.servo_compliance_beyond_encoder\.ML: cannot be"
    ):
        twin_effects(Cause(GIVES[1], ("ML",), (0.01,)))


def test_a_virtual_robot_sticks_and_slips_by_friction_that_falls_with_speed() -> None:
    (one,) = twin_effects(Cause("stick_slip", (), (1.5,)))
    assert (one.name, one.leg, one.values[0]) == ("stiction", "", 1.5)


def test_a_form_is_read_back_as_what_the_simulator_adds(tmp_path: Path) -> None:
    file = tmp_path / "d.json"
    file.write_text(json_text(diagnosis_json(late("lag", 0.05))))
    (cause,) = read_diagnosis(file, LATE.effects).causes
    assert cause.effect == "lag"
    (written,) = json.loads(file.read_text())["causes"]
    assert (written["effect"], written["form"]) == ("delay", "lag")


@pytest.mark.parametrize(
    ("reality", "form"),
    [
        pytest.param("play_outside", GIVES[1], marks=THOROUGH),
        pytest.param("usual", GIVES[0], marks=THOROUGH),
    ],
)
def test_a_virtual_robot_that_gives_before_or_behind_its_encoder(
    reality: str, form: str, tmp_path: Path
) -> None:
    """Physics of its own: in one the encoder is on the motor's side of the gear, in the other behind it."""

    def walk(name: str, seed: int, steer: float, *effect: str) -> Path:
        out = tmp_path / f"{name}{seed}.parquet"
        words = ["sim", "run", "--fast", "--reality", reality, "--frequency-hz", "0.2"]
        words += ["--seconds", "10", "--steer", str(steer), "--seed", str(seed), *effect]
        assert command([*words, "--out", str(out)]) == 0
        return out

    given = ("--effect", "servo_compliance:rad_per_nm=0.04")
    trials = [walk("t", 81 + k, 0.1 * k, *given) for k in range(2)]
    healthy = [walk("h", 91 + k, 0.05 * k) for k in range(5)]
    runs, whole = read_case(tuple(trials), tuple(healthy))
    others = {effect.family for effect in whole.effects} - SHORTENED
    references = list(runs.references)
    control = references.pop(2)  # steered less than some of them and more than others
    for run, named in ((runs.trials, [("servo_compliance", (), form)]), ([control], [])):
        lacking = Without(whole, tuple(others))
        d = diagnose_study(commissioned_study(run, lacking, references, standing=STANDING))
        assert [(one.effect, one.joints, one.form) for one in d.causes] == named
        for one in d.causes:  # short walks, and a baseline that was not fitted to them
            assert one.values[0].value == pytest.approx(0.04, rel=0.25)
    assert d.verdict is Verdict.NO_GAP
