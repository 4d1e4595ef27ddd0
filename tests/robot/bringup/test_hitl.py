"""The steps of the first day on a real robot, named by environment variables; skipped without one.

``BIGANT_HITL_PORT`` is the serial port of the servo bus, ``BIGANT_HITL_UNIT`` the force-torque unit
(HOST:UDP:CONSOLE, ``none`` by default), ``BIGANT_HITL_ROBOT`` the robot file. Steps that ask a person run
with ``BIGANT_HITL_PERSON=1`` and ``pytest -s``, those that move with ``BIGANT_HITL_ARMED=1`` as well: the
robot hangs in a frame then, a hand on the supply switch. ``bigant sim serve`` is a robot for the others.
"""

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from robot.bringup.first_day.bringup import FirstDay
from robot.bringup.first_day.day import DayOptions
from robot.bringup.first_day.record import FACTS_FILE
from robot.bringup.first_day.steps import STEPS, DayStep
from robot.bringup.preflight.finding import CheckVerdict
from robot.bringup.site import RealSite, SiteRequest
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.person import Consent, TerminalPerson
from sim_hw.faults.scenario import load_scenario
from tests.robot.sim_serve import ForkedSim

PORT = os.environ.get("BIGANT_HITL_PORT", "")
UNIT = os.environ.get("BIGANT_HITL_UNIT", "none")
ROBOT = Path(os.environ.get("BIGANT_HITL_ROBOT", str(DEFAULT_ROBOT_FILE)))
ARMED = os.environ.get("BIGANT_HITL_ARMED") == "1"
PERSON = os.environ.get("BIGANT_HITL_PERSON") == "1"
LOOP_S = float(os.environ.get("BIGANT_HITL_SECONDS", "10"))
BY_HAND = {4, 7, 9, 10, 13}


class AtTheTerminal(TerminalPerson):
    """Has agreed by setting the variables; still asked what is to be done and what was seen."""

    def allows(self, question: str, *, moves: bool) -> Consent:
        del question, moves
        return Consent.YES


@pytest.fixture(scope="module")
def real_day(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FirstDay]:
    config = load_robot(ROBOT)
    request = SiteRequest(hardware=PORT, force_unit=UNIT, armed=ARMED)
    folder = tmp_path_factory.mktemp("hitl")
    options = DayOptions(loop_s=LOOP_S, reboots=3)
    yield FirstDay(config, RealSite(request, config), AtTheTerminal(yes=True), options, folder)
    print(f"kept in {folder}")


@pytest.mark.hitl
@pytest.mark.skipif(not PORT, reason="no robot: set BIGANT_HITL_PORT (see the head of this file)")
@pytest.mark.parametrize("step", STEPS, ids=lambda step: f"{step.number}-{step.key}")
def test_a_step_on_the_real_robot(step: DayStep, real_day: FirstDay) -> None:
    if step.moves and not ARMED:
        pytest.skip("needs torque: set BIGANT_HITL_ARMED=1")
    if step.number in BY_HAND and not PERSON:
        pytest.skip("needs a person: set BIGANT_HITL_PERSON=1 and run pytest -s")
    real_day.do(only=step.number)
    outcome = real_day.record.latest[step.number]
    if outcome.ended == "refused":
        pytest.skip(outcome.findings[0].found)
    assert outcome.verdict is not CheckVerdict.FAIL, outcome.findings


@pytest.mark.soak
def test_the_real_path_on_served_devices(
    sim: ForkedSim, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The steps that need neither torque nor a person, over a pseudo-terminal and sockets, in real time."""
    words = ["bringup", "--hardware", sim.port, "--force-unit", sim.unit, "--yes"]
    words += ["--folder", str(tmp_path / "day")]
    for number in (1, 2, 3, 11):
        code = cli.run([*words, "--only", str(number)])
        assert code == 0, capsys.readouterr().out
    measured = load_scenario(tmp_path / "day" / FACTS_FILE, range(1, 7))
    assert measured.servo.firmware == 45
    assert measured.force_unit.banner
    assert cli.run([*words, "--only", "4"]) == 0
    out = capsys.readouterr().out
    assert "add --armed" in out
    assert not re.search(r"^ *fail", out, re.MULTILINE)


@pytest.fixture(scope="module")
def sim() -> Iterator[ForkedSim]:
    served = ForkedSim()
    yield served
    served.close()
