"""Draw what ``bigant robot show`` draws of the nominal robot's tripod: docs/figures/robot_show.png."""

from pathlib import Path

from gaits.catalog import make_gait
from robot.config.robot_file import load_robot
from robot.design.review import review_robot
from robot.report.robot_figures import draw_review

OUT = Path(__file__).resolve().parent / "figures" / "robot_show.png"


def main() -> None:
    """Draw it."""
    config = load_robot()
    review = review_robot(config, [make_gait("tripod", config.parameters)])
    OUT.parent.mkdir(exist_ok=True)
    draw_review(review)["tripod over one cycle"].savefig(OUT, dpi=110)
    print(OUT.name)


if __name__ == "__main__":
    main()
