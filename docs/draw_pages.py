"""Draw the upper parts of two pages: docs/figures/walk_page.png and odometry_page.png.

The walk is one of the slipping gait; for its odometry an encoder is silent for a second. Needs a Chromium;
without one it says so and leaves the pictures as they are.
"""

import tempfile
from contextlib import chdir
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.odometry.bars import without_encoder
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_stamped_ticks
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.odometry.compare import compare_methods, stride_of
from robot.odometry.page import odometry_page
from robot.odometry.track import TrackedLog, track
from tests.robot.browser import find_browser
from tests.robot.driven_browser import Tab, driven_browser

OUT = Path(__file__).resolve().parent / "figures"
WIDTH_PX = 1100
SHOWN_AT_S = 11.0  # of the replay
WALK = "drive --gait metachronal --cycles 2 --seed 5 --virtual-time --log"
SILENT = (15.0, 16.0)  # seconds of the log in which the encoder of ML is
ML = 1


def odometry_of(log: Path) -> str:
    """Take the readings of an encoder away from a walk, and return the page of its odometry."""
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


def draw(tab: Tab, page: Path, height_px: int, out: Path) -> None:
    """Show a page, its replay amid the walk, and write a picture of its upper part."""
    tab.show(WIDTH_PX, height_px).open(page)
    tab.until("[...document.querySelectorAll('figure.plot')].every(figure => figure.dataset.drawn"
              " || figure.getBoundingClientRect().top > innerHeight)")  # fmt: skip
    tab.run(
        f"document.querySelectorAll('figure.replay').forEach(one => one.replay.seek({SHOWN_AT_S}))"
    )
    tab.run("new Promise(done => setTimeout(done, 500))")
    print(tab.picture(out).name)


def main() -> None:
    """Walk, write both pages, and draw them."""
    if not find_browser():
        print("the pictures are left as they are: they need a Chromium")
        return
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        log, odometry = Path("walk.mcap"), folder / "odometry.html"
        with chdir(folder):  # the page names its log as it was given
            for words in ((*WALK.split(), str(log)), ("show", str(log))):
                if code := cli.run([*words]):
                    raise SystemExit(code)
        odometry.write_text(odometry_of(folder / log), encoding="utf-8")
        with driven_browser(folder) as tab:
            draw(tab, folder / "walk.html", 1350, OUT / "walk_page.png")
            draw(tab, odometry, 1900, OUT / "odometry_page.png")


if __name__ == "__main__":
    main()
