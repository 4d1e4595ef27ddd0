"""``bigant bringup``: the steps one after the other, each asked for, kept, judged and put on the page."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from model.errors import BigantError, ConfigError, RecordError
from model.values.wire import WireBytes
from record.earlier_file import keep_earlier
from record.log.writer import LogWriter
from robot.bringup.first_day.day import Day, DayOptions, KeepBytes, run_header, worst
from robot.bringup.first_day.record import (
    ABORTED,
    DONE,
    FACTS_FILE,
    PAGE_FILE,
    REFUSED,
    SKIPPED,
    Outcome,
    Record,
    load,
    mapping_digest,
    rewrite,
    save,
)
from robot.bringup.first_day.steps import STEPS, DayStep
from robot.bringup.mapping.motion import TorqueStillOn
from robot.bringup.preflight.finding import CheckVerdict, Finding, failed, lines_of, skipped
from robot.bringup.site import Site, site_of, site_request
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.person import Consent, Person
from robot.requests.single import BringupRequest
from robot.run.header import VIRTUAL_EPOCH_UNIX_NS

LOOP_S, VIRTUAL_LOOP_S = 600.0, 10.0
REBOOTS, VIRTUAL_REBOOTS = 10, 3


def bring_up(request: BringupRequest) -> ExitCode:
    """Do the steps that are left, or those asked for.

    Returns:
        OK, or VERDICT_FAILED when a step failed.

    Raises:
        BigantError: An argument or a file cannot be used, or torque is not confirmed off.
    """
    if request.list:
        for step in STEPS:
            print(f"{step.number:>2}  {step.title:<32} {step.words}")
        return ExitCode.OK
    if request.begin is not None and request.only is not None:
        raise ConfigError("--only", "and --from exclude each other; choose one")
    config = load_robot(request.robot)
    site = site_of(site_request(request), config)
    if request.ask and not site.virtual:
        raise ConfigError(
            "--ask", "needs --hardware virtual; with real hardware you are asked anyway"
        )
    person = site.person(yes=request.yes, ask=request.ask)
    options = DayOptions(
        request.seconds or (VIRTUAL_LOOP_S if site.virtual else LOOP_S),
        request.reboots or (VIRTUAL_REBOOTS if site.virtual else REBOOTS),
    )
    return FirstDay(config, site, person, options, request.folder).do(request.begin, request.only)


class FirstDay:
    """The day of one robot.

    Args:
        config: Robot file.
        site: The robot.
        person: Whoever stands next to it.
        options: How thorough.
        folder: Where everything is kept; it is made if it is not there.

    Raises:
        ConfigError: The folder holds the day of another robot.
        RecordError: The folder cannot be made.
    """

    def __init__(
        self, config: RobotConfig, site: Site, person: Person, options: DayOptions, folder: Path
    ) -> None:
        self._config, self._site, self._person = config, site, person
        self._options, self._folder = options, folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            why = f"{folder} cannot be made: {error.strerror}; choose another --folder"
            raise RecordError(why) from error
        self.record = load(folder) or Record(config.name, site.name)
        here = (config.name, "virtual" if site.virtual else "real")
        there = (self.record.robot, "virtual" if self.record.hardware == "virtual" else "real")
        if here != there:
            raise ConfigError(
                "--folder",
                f"{folder} holds the first day of {' '.join(reversed(there))}; choose another",
            )
        self._mapping = mapping_digest(config.servo_bus)

    def do(self, begin: int | None = None, only: int | None = None) -> ExitCode:
        """Do the steps that are left.

        Args:
            begin: Begin with this step, done or not; None with the first that is left.
            only: Do this one only.

        Returns:
            OK, or VERDICT_FAILED when a step failed.

        Raises:
            TorqueStillOn: Torque is not confirmed off.
        """
        code = ExitCode.OK
        for step in self._chosen(begin, only):
            print(f"\nstep {step.number} of {len(STEPS)}: {step.title}\n  {step.words}", flush=True)
            outcome = self._outcome(step)
            if outcome is None:
                print(f"stopped before step {step.number}; the same command goes on from there")
                break
            if outcome.verdict is CheckVerdict.FAIL:
                code = ExitCode.VERDICT_FAILED
                print(
                    f"step {step.number} failed: correct it, then start again; it is repeated first"
                )
                break
        print(f"\npage: {self._folder / PAGE_FILE}   measured: {self._folder / FACTS_FILE}")
        return code

    def _chosen(self, begin: int | None, only: int | None) -> list[DayStep]:
        if only is not None:
            return [step for step in STEPS if step.number == only]
        if begin is not None:
            return [step for step in STEPS if step.number >= begin]
        done = {s.number for s in STEPS if self.record.settled(s.number, self._mapping_of(s))}
        left = [step for step in STEPS if step.number not in done]
        if not left:
            print("all steps are done; repeat one with --only N")
        elif done:
            print(
                f"{len(done)} of {len(STEPS)} steps are done, going on with step {left[0].number}"
            )
        return left

    def _outcome(self, step: DayStep) -> Outcome | None:
        """Ask for a step, do it and keep it; None if the person wants to stop."""
        reason = self._reason_against(step)
        if reason:
            return self._keep(step, REFUSED, 0.0, [skipped("step", reason)], None)
        consent = self._person.allows(f"do step {step.number}?", moves=step.moves or step.writes)
        if consent is Consent.QUIT:
            return None
        if consent is Consent.SKIP:
            return self._keep(step, SKIPPED, 0.0, [skipped("step", "skipped")], None)
        return self._do(step)

    def _mapping_of(self, step: DayStep) -> str:
        """Return what must not have changed since a step was done; empty for nothing."""
        return self._mapping if step.maps else ""

    def _reason_against(self, step: DayStep) -> str:
        if step.moves and not self._site.armed:
            return "needs torque: hang the robot up, a hand on the supply switch, and add --armed"
        needed = [STEPS[number - 1] for number in step.needs]
        missing = [s for s in needed if not self.record.passed(s.number, self._mapping_of(s))]
        if missing:
            listed = ", ".join(str(one.number) for one in missing)
            file = " (with the ids, signs and zeros of this robot file)"
            return f"needs step {listed} first" + file * any(one.maps for one in missing)
        return ""

    def _do(self, step: DayStep) -> Outcome:
        log = self._folder / f"step-{step.number:02d}.mcap"
        keep_earlier(log)
        clock = self._site.wires(None).clock
        began_ns = clock.now_ns()
        with self._bytes_log(step, log, began_ns) as keep:
            day = Day(
                self._config,
                self._site,
                self._person,
                self._options,
                self._folder,
                log,
                _tell,
                keep,
            )

            def ended(how: str) -> Outcome:
                seconds = (clock.now_ns() - began_ns) * 1e-9
                return self._keep(step, how, seconds, day.findings, day)

            try:
                step.run(day)
            except TorqueStillOn as error:
                day.note(failed("torque", str(error), "cut the power"))
                ended(ABORTED)
                raise
            except BigantError as error:
                day.note(failed("step", str(error), "correct it and repeat this step"))
                return ended(ABORTED)
            except KeyboardInterrupt:
                day.note(failed("step", "interrupted", "repeat this step"))
                ended(ABORTED)
                raise
            return ended(DONE)

    @contextmanager
    def _bytes_log(self, step: DayStep, log: Path, start_ns: int) -> Iterator[KeepBytes]:
        """Yield what keeps raw bytes in the step's log; a step with a log of its own keeps them there.

        Where nothing passed there is no log.
        """
        if step.own_log:
            yield _nobody
            return
        header = run_header(self._config, self._site)
        writer = LogWriter(
            log,
            names=self._config.servo_bus.names,
            config_text=self._config.text,
            metadata={**header.metadata(), "step": step.key},
            start_ns=start_ns,
            start_unix_ns=VIRTUAL_EPOCH_UNIX_NS if self._site.virtual else time.time_ns(),
        )
        passed = 0

        def keep(pieces: tuple[WireBytes, ...]) -> None:
            nonlocal passed
            passed += len(pieces)
            writer.write_wires(pieces)

        try:
            yield keep
        finally:
            writer.close()
            if not passed:
                log.unlink()
        if writer.error is not None:
            raise writer.error

    def _keep(
        self, step: DayStep, ended: str, seconds: float, findings: list[Finding], day: Day | None
    ) -> Outcome:
        """Add an outcome to state, facts and page."""
        if day is None:
            for finding in findings:
                _tell(finding)
        else:
            day.heard()
        outcome = Outcome(
            number=step.number,
            key=step.key,
            ended=ended,
            verdict=worst(findings),
            unix_ns=time.time_ns(),
            seconds=seconds,
            mapping=self._mapping,
            findings=tuple(findings),
            facts=() if day is None else tuple(day.facts),
            curves=() if day is None else tuple(day.curves),
        )
        self.record = replace(self.record, outcomes=(*self.record.outcomes, outcome))
        save(self.record, self._folder)
        from robot.bringup.first_day.page import day_page  # draws: loaded only here

        rewrite(self._folder / PAGE_FILE, day_page(self.record, self._config))
        return outcome


def _tell(finding: Finding) -> None:
    print("\n".join(f"  {line}" for line in lines_of(finding)), flush=True)


def _nobody(_: tuple[WireBytes, ...]) -> None:
    """The step keeps its bytes itself."""
