"""Draw the upper part of the page of ``bigant odom --compare --html``: docs/figures/odometry_page.png.

The walk is one of the slipping gait, with an encoder that is silent for a second. Needs a Chromium; without
one it says so and leaves the picture as it is.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.odometry_bars import without_encoder
from record.log.reader import LogContents, read_log, read_stamped_ticks
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.odometry.compare import compare_methods, stride_of
from robot.odometry.page import odometry_page
from robot.odometry.track import TrackedLog, track
from tests.robot.browser import find_browser, run_browser

OUT = Path(__file__).resolve().parent / "figures" / "odometry_page.png"
SIZE = (1100, 2300)
WALK = "drive --gait metachronal --cycles 2 --seed 5 --virtual-time --log"
SILENT = (15.0, 16.0)  # seconds of the log in which the encoder of ML is
ML = 1


def page_of_walk(log: Path) -> str:
    """Walk, take the readings of an encoder away, and return the page."""
    if code := cli.run([*WALK.split(), str(log)]):
        raise SystemExit(code)
    items, config, read = list(read_stamped_ticks(log, LogContents())), load_robot(), read_log(log)
    begun_ns = items[0].unix_ns
    items = [
        without_encoder(one, ML)
        if SILENT[0] <= (one.unix_ns - begun_ns) * 1e-9 < SILENT[1]
        else one
        for one in items
    ]
    angle, rate = (
        np.array([getattr(one.tick.joints, name) for one in items])
        for name in ("angle_rad", "rate_rad_s")
    )
    read = replace(read, angle_rad=angle, rate_rad_s=rate)  # the open loop misses it, too
    tracked = TrackedLog(read, config, track(items, config))
    comparison = compare_methods(tracked, stride_m=stride_of(read))
    return odometry_page(comparison, Path("runs") / log.name, "in virtual time")


def main() -> None:
    """Write the page, and a picture of it."""
    if not find_browser():
        print(f"{OUT.name} left as it is: needs a Chromium")
        return
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder) / "page.html"
        page.write_text(page_of_walk(Path(folder) / "walk.mcap"), encoding="utf-8")
        width, height = SIZE
        words = f"--screenshot={OUT}", f"--window-size={width},{height}", page.as_uri()
        run_browser(Path(folder), *words)
    print(OUT.name)


if __name__ == "__main__":
    main()
