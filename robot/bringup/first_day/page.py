"""The page of the first day: the robot by what was found, one sentence, then every step in numbers."""

from robot.bringup.first_day.picture import curves_picture, draw_day
from robot.bringup.first_day.record import DONE, Record
from robot.bringup.first_day.steps import STEPS
from robot.bringup.preflight.finding import CheckVerdict
from robot.config.robot_file import RobotConfig
from robot.console.installed import version_lines
from robot.report.page import Section, report_page
from robot.report.pictures import page_picture
from robot.report.plan_view import LegPlaces, leg_places
from robot.report.run_date import utc_words

SAYS = (
    "Left: each leg by the worst that the latest outcome of a step found about it. Right: what each step "
    "found, a mark a finding; the numbers are those of the page to print."
)


def day_page(record: Record, config: RobotConfig) -> str:
    """Return the page.

    Args:
        record: The day so far.
        config: The robot file in use.
    """
    latest = record.latest
    failing = [outcome for outcome in latest.values() if outcome.verdict is CheckVerdict.FAIL]
    bad = [str(outcome.number) for outcome in failing if outcome.ended == DONE]
    left = [step for step in STEPS if step.number not in latest or not latest[step.number].good]
    if bad:
        verdict, kind = f"Not fit: step {', '.join(bad)} failed.", "fail"
    elif failing:
        numbers = ", ".join(str(outcome.number) for outcome in failing)
        verdict, kind = f"Step {numbers} was broken off.", "warn"
    elif left:
        verdict, kind = f"{len(STEPS) - len(left)} of {len(STEPS)} steps done.", "warn"
    else:
        verdict, kind = "All steps done.", "pass"
    where = "virtual devices, virtual time" if record.hardware == "virtual" else record.hardware
    return report_page(
        f"{record.robot}: first day",
        f"{where}; {len(record.outcomes)} outcomes, the last of each step is shown",
        [_advice(record), _table(record), _facts(record), *_details(record, leg_places(config))],
        lead=page_picture(
            draw_day(record, config), "The robot from above, and all steps", "0", SAYS
        ),
        verdict=verdict,
        kind=kind,
        footer=version_lines()[0],
    )


def _advice(record: Record) -> Section:
    rows = [
        (f"step {outcome.number}, {finding.name}", finding.advice)
        for outcome in record.latest.values()
        for finding in outcome.findings
        if finding.advice
    ]
    return Section("What to do", rows)


def _table(record: Record) -> Section:
    rows = []
    for step in STEPS:
        outcome = record.latest.get(step.number)
        row = ["", "not yet", "", ""]
        if outcome is not None:
            row = [
                outcome.verdict.value, outcome.ended, f"{outcome.seconds:.1f} s",
                utc_words(outcome.unix_ns),
            ]  # fmt: skip
        rows.append((row[0], str(step.number), step.title, *row[1:]))
    return Section("Steps", rows, ("", "step", "what", "ended", "took", "when"), (1,))


def _facts(record: Record) -> Section:
    rows = [
        (f"{fact.table}.{fact.key}", _shown(fact.value), f"step {outcome.number}: {fact.how}")
        for fact, outcome in record.facts.values()
    ]
    return Section("Measured", rows, ("key", "value", "how"))


def _shown(value: object) -> str:
    return repr(value) if isinstance(value, str) else str(value)


def _details(record: Record, places: LegPlaces) -> list[Section]:
    titles = {step.number: step.title for step in STEPS}
    sections = []
    for number, outcome in record.latest.items():
        if number not in titles:
            continue
        title, rows = f"Step {number}: {titles[number]}", [
            (f.verdict.value, f.name, f.found) for f in outcome.findings
        ]  # fmt: skip
        if outcome.curves:
            picture = curves_picture(
                f"{title}, each leg", f"step-{number}", outcome.curves, places.sides
            )
            sections.append(Section(title, picture=picture))
            title = ""
        sections.append(Section(title, rows, ("", "what", "found")))
    return sections
