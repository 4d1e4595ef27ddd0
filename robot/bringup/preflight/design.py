"""Whether the robot of the robot file can walk its gaits, as far as the model can tell."""

from collections.abc import Iterator

from robot.bringup.preflight.finding import Finding, failed, passed, warned
from robot.design.concern import Severity
from robot.design.review import RobotReview

NAME = "robot file"


def design_findings(review: RobotReview) -> Iterator[Finding]:
    """Judge a robot file by its review: one finding for each warning, or one that there is none."""
    for one in review.warnings:
        judged = failed if one.severity is Severity.IMPOSSIBLE else warned
        yield judged(NAME, f"{one.place} {one.topic}: {one.reason}", one.advice)
    if not review.warnings:
        margins = [
            f"{one.figures.gait} {one.figures.margin_m * 1e3:.0f} mm from tipping"
            for one in review.gaits
        ]
        yield passed(NAME, "; ".join(margins) or "it has no gait to judge")
