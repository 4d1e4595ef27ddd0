"""The first day on a virtual robot: each step, what it settles and finds, and every way to leave it."""

import html
import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.faults.cases import FLIPPED, TOGETHER, assumed
from drivers.ati.foot_forces import ForceScales
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.frames import Instruction, build_instruction
from gaits.plan import Hold
from model.errors import BusError, ConfigError
from model.values.wire import Wire
from record.log.reader import LogContents, read_wires
from record.log.survey import survey_log
from robot.bringup.first_day.bringup import FirstDay
from robot.bringup.first_day.day import DayOptions
from robot.bringup.first_day.page import day_page
from robot.bringup.first_day.record import FACTS_FILE, Record, load
from robot.bringup.first_day.steps import STEPS
from robot.bringup.mapping.identify import Press, press_findings
from robot.bringup.mapping.jog import Jog, jog_findings
from robot.bringup.mapping.motion import GatedShafts, TorqueStillOn, limp_afterwards
from robot.bringup.preflight.design import design_findings
from robot.bringup.preflight.finding import CheckVerdict, Finding
from robot.bringup.site import SiteRequest, VirtualSite
from robot.cli import main as cli
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.console.person import Consent, Hand, Sight, TerminalPerson, Work
from robot.design.review import review_for_run
from robot.virtual.hung import VirtualPerson
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.faults.scenario import load_scenario, parse_scenario
from tests.robot.design.robot_files import robot_with
from tests.robot.design.test_concerns import moved
from tests.robot.other_servos import MIXED, MIXED_MODELS, other_robot
from tests.robot.report.text_only import without_pictures
from tests.soaked import soaked

CONFIG = load_robot()
QUICK = DayOptions(loop_s=1.0, reboots=1, frequency_hz=0.3)
IDS = [int(i) for i in CONFIG.servo_bus.ids]
OTHER_SERVOS = assumed(("a watchdog hears only its own id", "a servo restarts in 0.8 s"))
# All but the loop and the walks, whose time is the controller's.
DEVICE_STEPS = (1, 2, 3, 4, 5, 6, 7, 9, 10, 11)


def site_with(
    tmp_path: Path, scenario: str = "", there: str = "", config: RobotConfig = CONFIG
) -> VirtualSite:
    """A virtual robot with other assumptions, or of another robot file than the drivers use."""
    request = SiteRequest()
    if scenario:
        path = tmp_path / "scenario.toml"
        path.write_text(scenario, encoding="utf-8")
        request = replace(request, scenario=path)
    if there:
        path = tmp_path / "there.toml"
        path.write_text(there, encoding="utf-8")
        request = replace(request, virtual_robot=path)
    return VirtualSite(request, config)


def first_day(
    tmp_path: Path, site: VirtualSite, person: VirtualPerson | None = None,
    config: RobotConfig = CONFIG,
) -> FirstDay:  # fmt: skip
    whom = person or site.person(yes=False, ask=False)
    return FirstDay(config, site, whom, QUICK, tmp_path / "day")


def do_steps(day: FirstDay, numbers: Sequence[int], *, page: bool = False) -> Record:
    """Do steps; of the page that each of them writes, none is made, or only the last, without pictures."""
    for number in numbers:
        with pytest.MonkeyPatch.context() as patch, without_pictures():
            if not page or number != numbers[-1]:
                patch.setattr("robot.bringup.first_day.page.day_page", no_page)
            day.do(only=number)
    return day.record


def no_page(record: Record, config: RobotConfig) -> str:
    """In place of a page that nobody reads: it takes far longer than the step."""
    return ""


def findings_of(record: Record, number: int) -> dict[str, Finding]:
    return {finding.name: finding for finding in record.latest[number].findings}


def torque_of(site: VirtualSite) -> list[int]:
    return [servo.table.get("torque_enable") for servo in site.robot.devices.servos.servos]


def drawn_in_the_end(record: Record, config: RobotConfig) -> str:
    """The page as after each step, with pictures once all are done."""
    if len(record.latest) == len(STEPS):
        return day_page(record, config)
    with without_pictures():
        return day_page(record, config)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Record, VirtualSite]:
    """A whole day, all thirteen steps in a row, with servos that the walks meet as other ones."""
    folder = tmp_path_factory.mktemp("whole")
    site = site_with(folder, OTHER_SERVOS)
    day = first_day(folder, site)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robot.bringup.first_day.page.day_page", drawn_in_the_end)
        assert day.do() is ExitCode.OK
    return folder / "day", day.record, site


# Each step.


@pytest.mark.soak
@pytest.mark.parametrize("step", STEPS, ids=lambda step: f"{step.number}-{step.key}")
def test_a_step_ends_well_and_keeps_its_bytes(
    step: object, whole: tuple[Path, Record, VirtualSite]
) -> None:
    folder, record, _ = whole
    number = step.number  # type: ignore[attr-defined]
    outcome = record.latest[number]
    bad = [f for f in outcome.findings if f.verdict in {CheckVerdict.FAIL, CheckVerdict.WARN}]
    assert outcome.ended == "done"
    assert not bad
    if number == 1:  # nobody speaks
        assert not (folder / "step-01.mcap").exists()
        return
    contents = LogContents()
    pieces = list(read_wires(folder / f"step-{number:02d}.mcap", contents))
    wires = {piece.wire for piece in pieces if piece.data}
    if number in {10, 11}:
        assert Wire.FORCE_CONSOLE in wires
        assert not contents.damage
    else:
        assert Wire.SERVO_BUS in wires


@pytest.mark.soak
def test_the_day_is_on_one_page_and_in_three_files(whole: tuple[Path, Record, VirtualSite]) -> None:
    folder, record, _ = whole
    page = html.unescape((folder / "first_day.html").read_text(encoding="utf-8"))
    assert "All steps done." in page
    assert all(f"Step {step.number}: {step.title}" in page for step in STEPS)
    assert load(folder) == record
    assert "CAL of transducer 6" in (folder / "console.txt").read_text(encoding="utf-8")
    assert (folder / "servos.toml").read_text(encoding="utf-8").count("[[servo]]") == 6


@pytest.mark.soak
def test_each_leg_is_kept_and_drawn_against_what_was_expected(
    whole: tuple[Path, Record, VirtualSite],
) -> None:
    folder, record, _ = whole
    names = CONFIG.servo_bus.names
    curves = {number: {one.leg: one for one in outcome.curves}
              for number, outcome in record.latest.items() if outcome.curves}  # fmt: skip
    assert sorted(curves) == [4, 5, 7, 10, 12, 13]
    assert all(set(legs) == set(names) for legs in curves.values())
    turned = curves[4]["FL"]
    assert max(turned.expected) == pytest.approx(10.0, abs=0.01)
    np.testing.assert_allclose(turned.measured, turned.expected, atol=2.0)
    assert turned.x[-1] == pytest.approx(3.0, abs=0.2)
    assert len(curves[7]["HL"].measured) == QUICK.reboots
    assert min(curves[10]["MR"].measured) > 5.0, "up, forward and left by the robot file"
    for number in (12, 13):
        walked = curves[number]["HR"]
        assert abs(walked.measured[-1]) == pytest.approx(360.0, abs=10.0)
        np.testing.assert_allclose(walked.measured, walked.expected, atol=10.0)
    page = (folder / "first_day.html").read_text(encoding="utf-8")
    assert page.index("<svg") < page.index("class='verdict") < page.index("<h2>Steps")
    assert page.count("<figure class='plot'>") == 1 + len(curves)
    assert len(page) < 3_000_000
    state = json.loads((folder / "first_day.json").read_text(encoding="utf-8"))
    for outcome in state["outcomes"]:  # as an earlier version kept it
        del outcome["curves"]
        for finding in outcome["findings"]:
            del finding["legs"], finding["part"]
    (folder.parent / "old").mkdir()
    (folder.parent / "old" / "first_day.json").write_text(json.dumps(state), encoding="utf-8")
    old = load(folder.parent / "old")
    assert old is not None
    assert [one.verdict for one in old.outcomes] == [one.verdict for one in record.outcomes]
    assert day_page(old, CONFIG).count("<figure class='plot'>") == 1


@pytest.mark.soak
def test_torque_is_off_after_the_day(whole: tuple[Path, Record, VirtualSite]) -> None:
    assert torque_of(whole[2]) == [0] * 6


@pytest.mark.soak
@pytest.mark.parametrize("number", [2, 3, 8, 11])
def test_steps_that_only_ask_write_nothing_to_a_servo(
    number: int, whole: tuple[Path, Record, VirtualSite]
) -> None:
    ping, read, sync_read = 0x01, 0x02, 0x82
    for piece in read_wires(whole[0] / f"step-{number:02d}.mcap", LogContents()):
        if piece.wire is Wire.SERVO_BUS and piece.sent:
            assert piece.data[7] in {ping, read, sync_read}


# What is settled.


def check_facts(record: Record, scenario_text: str) -> None:
    """Hold every measured fact to what the virtual devices were told to be."""
    scenario = parse_scenario(scenario_text, IDS)
    waits_s = scenario.adapter.latency_timer_s
    near = {"processing_s": 2e-5, "restart_s": 0.008 + 2 * waits_s, "latency_timer_s": 1e-6}
    for (table, key), (fact, _) in record.facts.items():
        wanted = getattr(getattr(scenario, table), key)
        if key in near:
            assert fact.value == pytest.approx(wanted, abs=near[key]), key
        else:
            assert fact.value == wanted, key


def test_every_assumption_is_measured_in_some_set() -> None:
    assert sorted(words for together in TOGETHER for words in together) == sorted(FLIPPED)


@pytest.mark.parametrize(
    "together", soaked(TOGETHER, lambda one: one is TOGETHER[0], lambda one: one[0])
)
def test_what_was_assumed_is_measured(together: tuple[str, ...], tmp_path: Path) -> None:
    scenario = assumed(together)
    record = do_steps(first_day(tmp_path, site_with(tmp_path, scenario)), DEVICE_STEPS)
    assert [n for n, one in record.latest.items() if one.verdict is CheckVerdict.FAIL] == []
    assert len(record.facts) == 16
    check_facts(record, scenario)
    measured = load_scenario(tmp_path / "day" / FACTS_FILE, IDS)
    assert measured.force_unit.empty_line == "\r\n>"


@pytest.mark.soak
def test_a_whole_day_measures_other_servos(whole: tuple[Path, Record, VirtualSite]) -> None:
    check_facts(whole[1], OTHER_SERVOS)


@pytest.mark.soak
def test_a_day_ends_where_answers_take_longer_than_a_period(tmp_path: Path) -> None:
    site = site_with(tmp_path, FLIPPED["the adapter waits 16 ms"])
    day = first_day(tmp_path, site)
    assert day.do() is ExitCode.VERDICT_FAILED
    loop = findings_of(day.record, 8)["loop"]
    assert "the latency timer is 16 ms: set it to 1" in loop.advice
    assert max(day.record.latest) == 8


@pytest.mark.soak
def test_virtual_devices_behave_as_measured(tmp_path: Path) -> None:
    odd = '[servo]\nreserved = "error"\nwatchdog_hears = "own"\nrestart_s = 0.4\nfirmware = 44\n'
    odd += "[force_unit]\nbanner = false\nblank_line = true\nsequence_restarts = true\n"
    numbers = (2, 3, 6, 7, 10, 11)
    first = do_steps(first_day(tmp_path, site_with(tmp_path, odd)), numbers)
    again = tmp_path / "again"
    again.mkdir()
    measured = (tmp_path / "day" / FACTS_FILE).read_text(encoding="utf-8")
    second = do_steps(first_day(again, site_with(again, measured)), numbers)
    values = {key: fact.value for key, (fact, _) in first.facts.items()}
    others = {key: fact.value for key, (fact, _) in second.facts.items()}
    assert others.pop(("servo", "restart_s")) == pytest.approx(
        values.pop(("servo", "restart_s")), abs=0.01
    )
    assert others == values


def test_a_chain_that_breaks_at_an_absent_id_is_said(tmp_path: Path) -> None:
    site = site_with(tmp_path, "[servo]\nfirmware = 45\n")
    site.robot.devices.servos.silence(252, chain_breaks=True)
    record = do_steps(first_day(tmp_path, site), (2,))
    assert findings_of(record, 2)["a broken chain"].verdict is CheckVerdict.WARN


# A wrong robot file.


def changed(key: str, values: str) -> str:
    """The robot file with another list under one key."""
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8").replace("\n# up = ", "\nup = ")
    return re.sub(rf"^{key} = \[.*\]", f"{key} = {values}", text, flags=re.MULTILINE)


WRONG = (
    ("dynamixel_id", "[1, 3, 2, 4, 5, 6]", 4, "ids"),
    ("dynamixel_id", "[2, 3, 1, 4, 5, 6]", 4, "ids"),
    ("servo_sign", "[1, 1, -1, -1, 1, -1]", 4, "signs"),
    ("servo_zero", "[2048, 2048, 2300, 2048, 100, 2048]", 4, "zeros"),
    ("transducer", "[1, 6, 3, 4, 5, 2]", 10, "transducers"),
    ("yaw", "[0, 0, 1.57, 0, -2.5, 0]", 10, "sensor yaw"),
    ("up", "[1, 1, -1, 1, 1, -1]", 10, "sensor up"),
)

# Ids, signs and zeros are found together in ``test_all_mistakes_at_once``.
TELLING = ("yaw",)


@pytest.mark.parametrize(
    "wrong",
    soaked(WRONG, lambda wrong: wrong[0] in TELLING, lambda wrong: " ".join(map(str, wrong[::3]))),
)
def test_a_wrong_line_of_the_robot_file_is_found_and_the_right_one_given(
    wrong: tuple[str, str, int, str], tmp_path: Path
) -> None:
    key, values, number, name = wrong
    there = changed(key, values)
    site = site_with(tmp_path, there=there)
    record = do_steps(first_day(tmp_path, site), (2, 3, number))
    finding = findings_of(record, number)[name]
    assert finding.verdict is CheckVerdict.FAIL
    assert f"{key} = [" in finding.advice
    line = finding.advice.partition(": ")[2]
    wanted = np.array(json.loads(values))
    told = np.array(json.loads(line.partition(" = ")[2]))
    np.testing.assert_allclose(told, wanted, atol=0.1 if key == "yaw" else 0)
    # the file as it is told to be passes
    right = parse_robot(changed(key, line.partition(" = ")[2]))
    again = first_day(tmp_path, site_with(tmp_path, there=there, config=right), config=right)
    assert do_steps(again, (number,)).latest[number].verdict is CheckVerdict.PASS


def test_a_sensor_that_is_turned_over_and_turned_gives_the_same_forces() -> None:
    """Twin and driver agree on what up and yaw mean together: weight is up, in body axes."""
    text = changed("up", "[-1, 1, -1, 1, -1, 1]")
    text = text.replace(
        "yaw = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]", "yaw = [0.4, 0.0, -2.0, 1.0, 0.0, 3.0]"
    )
    found = []
    for config in (CONFIG, parse_robot(text)):
        rig = open_in_memory(config, VirtualSettings(armed=False))
        try:
            for _ in range(20):
                rig.clock.sleep_until_ns(rig.clock.now_ns() + 10_000_000)
                reading = rig.read()
            scales = ForceScales(rig.calibrations, config.force_sensor)
            forces = scales.forces(reading.forces[-1], np.zeros(6))
        finally:
            rig.close()
        found.append(forces.force_n)
    assert found[0][:, 2].min() > 5.0
    np.testing.assert_allclose(found[1], found[0], atol=0.3)


def test_all_mistakes_at_once(tmp_path: Path) -> None:
    text = changed("dynamixel_id", "[1, 3, 2, 4, 5, 6]")
    text = text.replace("servo_sign = [1, 1, 1, -1, -1, -1]", "servo_sign = [1, -1, 1, -1, -1, -1]")
    text = text.replace("servo_zero = [2048, 2048,", "servo_zero = [2048, 3000,")
    record = do_steps(first_day(tmp_path, site_with(tmp_path, there=text)), (2, 4), page=True)
    found = findings_of(record, 4)
    assert found["ids"].advice.endswith("dynamixel_id = [1, 3, 2, 4, 5, 6]")
    assert found["signs"].advice.endswith("servo_sign = [1, -1, 1, -1, -1, -1]")
    assert found["zeros"].advice.endswith("servo_zero = [2048, 3000, 2048, 2048, 2048, 2048]")


def test_an_id_that_the_robot_file_does_not_know(tmp_path: Path) -> None:
    site = site_with(tmp_path, there=changed("dynamixel_id", "[1, 2, 7, 4, 5, 6]"))
    record = do_steps(first_day(tmp_path, site), (2,))
    finding = findings_of(record, 2)["ids"]
    assert finding.verdict is CheckVerdict.FAIL
    assert "no answer from 3 (FL); id 7 answers" in finding.found
    assert "bigant servo setup --id 7 --new-id 3" in finding.advice


def test_a_servo_with_old_firmware_is_told_from_one_that_is_not_there(tmp_path: Path) -> None:
    site = site_with(tmp_path, "[servo]\nold_firmware = [3]\n")
    finding = findings_of(do_steps(first_day(tmp_path, site), (2,)), 2)["ids"]
    assert finding.found == "no answer from 3 (FL); id 3 answers in protocol 1.0"
    assert "Dynamixel Wizard" in finding.advice


def test_an_old_servo_is_told_the_firmware_of_its_own_model(tmp_path: Path) -> None:
    """Not that of the first servo which does not answer."""
    mixed = parse_robot(other_robot(*MIXED))
    site = site_with(tmp_path, "[servo]\nold_firmware = [4]\n", config=mixed)
    site.robot.devices.servos.silence(2)
    day = first_day(tmp_path, site, config=mixed)
    finding = findings_of(do_steps(day, (2,)), 2)["ids"]
    assert finding.found == "no answer from 2 (ML), 4 (HR); id 4 answers in protocol 1.0"
    models = dict(zip(IDS, MIXED_MODELS, strict=True))
    assert models[2] != models[4]
    assert finding.advice == f"put the {models[4]} firmware on it with Dynamixel Wizard"


def test_a_reversed_servo_is_found_in_its_registers(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    site.robot.devices.servos.servos[2].table.set("drive_mode", 1)
    record = do_steps(first_day(tmp_path, site), (2, 3))
    assert findings_of(record, 3)["FL"].verdict is CheckVerdict.FAIL
    assert "drive_mode 1 instead of 0" in findings_of(record, 3)["FL"].found


def test_somebody_else_on_the_bus_is_heard(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    ping = build_instruction(3, Instruction.PING)
    site.robot.cable.receive(ping, site.robot.clock.now_ns() + 5_000_000, 1_000_000)
    record = do_steps(first_day(tmp_path, site), (1,))
    finding = findings_of(record, 1)["servo bus"]
    assert finding.verdict is CheckVerdict.FAIL
    assert finding.found.startswith("14 bytes in 3 s without a request: ff ff fd 00 03")
    assert (tmp_path / "day" / "step-01.mcap").exists()


def a_jog(leg: str, servo_id: int, moved: str, **others: float) -> Jog:
    values = {"reached_deg": 10.0, "returned_deg": 0.0, **others}
    way = "backward" if moved in CONFIG.servo_bus.names else ""
    return Jog(leg, servo_id, 2048, 10.0, current_a=0.1, moved=moved, direction=way, **values)


def test_what_a_jog_can_show() -> None:
    def verdicts(*jogs: Jog) -> dict[str, CheckVerdict]:
        return {f.name: f.verdict for f in jog_findings(jogs, CONFIG.servo_bus)}

    assert verdicts(a_jog("HL", 1, "HL")) == {"HL": CheckVerdict.PASS, "zeros": CheckVerdict.PASS}
    assert verdicts(a_jog("HL", 1, "none")) == {"HL": CheckVerdict.FAIL}
    assert verdicts(a_jog("HL", 1, "several"))["HL"] is CheckVerdict.FAIL
    assert verdicts(a_jog("HL", 1, "HL", reached_deg=4.0))["HL"] is CheckVerdict.FAIL
    twice = jog_findings([a_jog("HL", 1, "ML"), a_jog("ML", 2, "ML")], CONFIG.servo_bus)
    assert twice[-1].found == "id 1 turned ML, id 2 turned ML"
    assert "two servos cannot turn one leg" in twice[-1].advice


UP, FORWARD, LEFT = (0.0, 0.0, 9.0), (9.0, 0.0, 0.0), (0.0, 9.0, 0.0)
Vector = tuple[float, float, float]


def some_presses(number: int, forces: tuple[Vector, Vector, Vector]) -> list[Press]:
    hands = (Hand.PRESS_UP, Hand.PRESS_FORWARD, Hand.PRESS_LEFT)
    return [Press("HL", hand, number, f, 0.2) for hand, f in zip(hands, forces, strict=True)]


def test_what_presses_can_show() -> None:
    def first(presses: list[Press]) -> Finding:
        return press_findings(presses, CONFIG.force_sensor)[0]

    assert first(some_presses(1, (UP, FORWARD, LEFT))).verdict is CheckVerdict.PASS
    nobody = first(some_presses(0, ((0.0,) * 3,) * 3))
    assert nobody.found == "no transducer measured it"
    reversed_sign = ((0.0, 0.0, -9.0), (-9.0, 0.0, 0.0), (0.0, -9.0, 0.0))
    assert "gives the force of the leg" in first(some_presses(1, reversed_sign)).found
    assert "up is not along its z" in first(some_presses(1, (FORWARD, UP, LEFT))).found
    crooked = first(some_presses(1, (UP, FORWARD, (8.0, 2.0, 0.0))))
    assert crooked.verdict is not CheckVerdict.PASS
    mixed = [*some_presses(1, (UP, FORWARD, LEFT))[:2], *some_presses(2, (UP, FORWARD, LEFT))[2:]]
    assert "measured by transducers 1, 2" in first(mixed).found


# Stopping and going on.


class _Stubborn(VirtualPerson):
    """Answers as told, and may press Ctrl-C at a time while something is watched."""

    consent: tuple[Consent, ...] = ()
    interrupt_at_s = float("inf")
    interrupt_in = ""
    plugs = True

    def allows(self, question: str, *, moves: bool) -> Consent:
        del question, moves
        if not self.consent:
            return Consent.YES
        first, *rest = self.consent
        self.consent = tuple(rest)
        return first

    def does(self, work: Work) -> None:
        if work.hand is Hand.PLUG_CABLE and not self.plugs:
            return
        super().does(work)

    def meanwhile(self, elapsed_s: float) -> None:
        if elapsed_s >= self.interrupt_at_s:
            raise KeyboardInterrupt
        super().meanwhile(elapsed_s)


def stubborn(site: VirtualSite) -> _Stubborn:
    return _Stubborn(site.robot, CONFIG.servo_bus.names)


@pytest.mark.usefixtures("words_only")
def test_quit_and_go_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    site = site_with(tmp_path)
    person = stubborn(site)
    person.consent = (Consent.YES, Consent.YES, Consent.SKIP, Consent.QUIT)
    assert first_day(tmp_path, site, person).do() is ExitCode.OK
    assert "stopped before step 4" in capsys.readouterr().out
    record = load(tmp_path / "day")
    assert record is not None
    assert list(record.latest) == [1, 2, 3]
    assert record.latest[3].ended == "skipped"
    person.consent = (Consent.QUIT,)
    first_day(tmp_path, site, person).do()
    assert "3 of 13 steps are done, going on with step 4" in capsys.readouterr().out


@pytest.mark.usefixtures("words_only")
@pytest.mark.parametrize("number", soaked([4, 9], lambda number: number == 4))
def test_ctrl_c_while_torque_is_on_leaves_torque_off(number: int, tmp_path: Path) -> None:
    site = site_with(tmp_path)
    person = stubborn(site)
    day = first_day(tmp_path, site, person)
    do_steps(day, (2, 3, 5, 6))
    held: list[int] = []

    class Looks(_Stubborn):
        def meanwhile(self, elapsed_s: float) -> None:
            held[:] = torque_of(site)
            super().meanwhile(elapsed_s)

    person.__class__ = Looks
    person.interrupt_at_s = 0.3
    with pytest.raises(KeyboardInterrupt):
        day.do(only=number)
    assert any(held)
    assert torque_of(site) == [0] * 6
    assert day.record.latest[number].ended == "aborted"
    person.interrupt_at_s = float("inf")
    assert day.do(only=number) is ExitCode.OK


@pytest.mark.usefixtures("words_only")
def test_torque_that_is_not_confirmed_off_is_said(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    person = stubborn(site)
    person.plugs = False
    day = first_day(tmp_path, site, person)
    do_steps(day, (2, 3, 5, 6))
    with pytest.raises(TorqueStillOn, match="cut the power"):
        day.do(only=9)
    assert day.record.latest[9].verdict is CheckVerdict.FAIL


def test_nothing_moves_unless_armed(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    site.armed = False
    record = do_steps(first_day(tmp_path, site), (2, 3, 4, 5, 6, 9, 12, 13), page=True)
    assert {n for n, one in record.latest.items() if one.ended == "refused"} == {4, 5, 6, 9, 12, 13}
    assert torque_of(site) == [0] * 6
    site.armed = True
    later = first_day(tmp_path, site)
    assert [step.number for step in later._chosen(None, None)][:2] == [1, 4]


def test_no_walk_before_each_leg_was_turned_with_this_robot_file(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    day = first_day(tmp_path, site)
    do_steps(day, (2, 3, 12))
    assert "needs step 4, 5, 6 first" in findings_of(day.record, 12)["step"].found
    do_steps(day, (4, 5, 6))
    other = parse_robot(changed("servo_sign", "[1, 1, -1, -1, -1, -1]"))
    record = do_steps(first_day(tmp_path, site, config=other), (12,))
    assert record.latest[12].ended == "refused"


@pytest.mark.parametrize(
    "shifted_m",
    [pytest.param(-0.085, id="tips", marks=pytest.mark.soak), pytest.param(0.6, id="falls over")],
)
def test_the_robot_file_is_judged_before_the_first_walk(shifted_m: float, tmp_path: Path) -> None:
    """By the same model as before a drive: a robot that tips walks, one that cannot stand does not."""
    config = robot_with({"legs.shaft_position": moved(shifted_m)})
    site = site_with(tmp_path, config=config)
    day = first_day(tmp_path, site, config=config)
    do_steps(day, (2, 3, 4, 5, 6))
    outcome = do_steps(day, (12,)).latest[12]
    judged = [one for one in outcome.findings if one.name == "robot file"]
    review = review_for_run(config, "tripod", QUICK.frequency_hz)
    assert judged == list(design_findings(review))
    log = tmp_path / "day" / "step-12.mcap"
    if shifted_m < 0:
        assert {one.verdict for one in judged} == {CheckVerdict.WARN}
        assert "+85 mm in x" in judged[0].advice
        assert {"walk", "shafts"} <= findings_of(day.record, 12).keys()
        kept = survey_log(log).metadata["warnings"].splitlines()
        assert kept == [one.line for one in review.warnings]
    else:
        assert judged[0].verdict is CheckVerdict.FAIL
        assert outcome.verdict is CheckVerdict.FAIL
        assert not log.exists()
    assert torque_of(site) == [0] * 6


def test_a_skipped_step_is_not_repeated_and_proves_nothing(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    person = stubborn(site)
    person.consent = (Consent.YES, Consent.YES, Consent.SKIP)
    day = first_day(tmp_path, site, person)
    do_steps(day, (2, 3, 4, 5, 6, 12))
    assert day.record.latest[4].ended == "skipped"
    assert "needs step 4 first" in findings_of(day.record, 12)["step"].found
    assert 4 not in [step.number for step in day._chosen(None, None)]


def test_a_folder_of_another_robot_is_refused(tmp_path: Path) -> None:
    day = first_day(tmp_path, site_with(tmp_path))
    do_steps(day, (1,))
    other = replace(CONFIG, name="another")
    with pytest.raises(ConfigError, match="holds the first day of virtual BigANT"):
        first_day(tmp_path, site_with(tmp_path), config=other)
    (tmp_path / "day" / "first_day.json").write_text("{}", encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be read"):
        first_day(tmp_path, site_with(tmp_path))


# Motion.


def test_the_gate_is_the_only_way_to_a_goal(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    port = site.wires(None).port
    bus = ServoBus(port, CONFIG.servo_bus)
    bus.connect()
    bus.configure()
    before = site.robot.world.shaft_angle_rad

    def jump() -> None:
        with limp_afterwards(bus):
            shafts = GatedShafts(bus, CONFIG)
            shafts.follow(Hold(shafts.angle_rad + 1.0), 1.0)

    with pytest.raises(BusError, match="the safety gate refuses it"):
        jump()
    assert torque_of(site) == [0] * 6
    np.testing.assert_allclose(site.robot.world.shaft_angle_rad, before, atol=0.01)


def test_a_jog_switches_one_servo_on_only(tmp_path: Path) -> None:
    site = site_with(tmp_path)
    seen: set[tuple[int, ...]] = set()

    class Looks(VirtualPerson):
        def meanwhile(self, elapsed_s: float) -> None:
            seen.add(tuple(torque_of(site)))
            super().meanwhile(elapsed_s)

    day = first_day(tmp_path, site, Looks(site.robot, CONFIG.servo_bus.names))
    do_steps(day, (2,))
    assert day.do(only=4) is ExitCode.OK
    assert "<figure class='plot'>" in (tmp_path / "day" / "first_day.html").read_text()
    assert seen == {tuple(int(k == leg) for k in range(6)) for leg in range(6)}


def test_a_virtual_robot_may_differ_from_the_robot_file() -> None:
    there = parse_robot(changed("servo_zero", "[2148, 2048, 2048, 2048, 2048, 2048]"))
    rig = open_in_memory(CONFIG, VirtualSettings(there=there))
    try:
        ticks = rig.bus.read().position_ticks
    finally:
        rig.close()
    assert abs(ticks[0] - 2148) < 5
    assert abs(ticks[1] - 2048) < 5


# Commands and people.


@pytest.mark.usefixtures("words_only")
def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = tmp_path / "there.toml"
    there.write_text(changed("dynamixel_id", "[1, 3, 2, 4, 5, 6]"), encoding="utf-8")
    assert cli.run(["bringup", "--list"]) == 0
    assert capsys.readouterr().out.count("\n") == 13
    folder = str(tmp_path / "day")
    assert cli.run(["bringup", "--folder", folder, "--only", "13"]) == 0
    assert "needs step 4, 5, 6, 10, 12 first" in capsys.readouterr().out
    assert cli.run(["bringup", "--folder", folder, "--only", "1", "--from", "2"]) == 2
    assert cli.run(["servo", "jog", "--leg", "FL", "--json", "--virtual-robot", str(there)]) == 1
    out = json.loads(capsys.readouterr().out)
    assert out["jogs"][0]["moved"] == "ML"
    assert cli.run(["servo", "jog", "--leg", "XX"]) == 2
    assert cli.run(["servo", "jog", "--hardware", "/dev/null", "--leg", "FL"]) == 2
    assert "--armed is needed" in capsys.readouterr().err.replace(":", "")
    assert cli.run(["force", "identify", "--hardware", "virtual", "--leg", "FL", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["findings"][0]["verdict"] == "pass"


def test_a_person_at_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = iter(["what", "skip", "q", "", "no leg", "fl"])
    monkeypatch.setattr("builtins.input", lambda _: next(answers))
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    person = TerminalPerson(yes=True)
    assert person.allows("may I?", moves=False) is Consent.YES
    assert person.allows("may I?", moves=True) is Consent.SKIP
    assert person.allows("may I?", moves=True) is Consent.QUIT
    person.does(Work(Hand.PLUG_CABLE, "plug it in"))
    assert person.sees(Sight.WHICH_LEG, "which?", ("FL", "none")) == "FL"
    monkeypatch.setattr("sys.stdin.isatty", lambda: False)
    assert person.allows("may I?", moves=True) is Consent.SKIP
    assert "nobody is there to be asked" in capsys.readouterr().out
