"""Pages in a headless Chromium, clicked and scrubbed: the robot moves, curves hide, zoom, show values."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from model.motion.filters import play
from record.trial.trial import write_trial
from robot.cli import main as cli
from tests.gap.bench_trials import IDEAL, servo_trial
from tests.robot.browser import find_browser
from tests.robot.driven_browser import Tab, driven_browser

pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(not find_browser(), reason="there is no Chromium on this computer"),
]

MOST_BYTES = 6_000_000
SMALL_PX = 360
REPLAY = "document.querySelector('figure.replay').replay"
PLOT = "document.querySelector('figure.plot')"
DRAWN = "document.querySelector('figure.plot').dataset.drawn"
# Brings every plot of a page near the screen, and waits until each is drawn.
ALL_DRAWN = """(async () => {
  for (const figure of document.querySelectorAll('figure.plot')) {
    for (let up = figure; up; up = up.parentElement) if (up.tagName === 'DETAILS') up.open = true;
    figure.scrollIntoView();
    while (!figure.dataset.drawn) await new Promise(done => setTimeout(done, 10));
  }
  return bigant.plots.length;
})()"""
WIDE = "[document.documentElement.scrollWidth, innerWidth]"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    with driven_browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture
def walk(browser: Tab, walk_pages: Path) -> Tab:
    return browser.show(1100).open(walk_pages / "show.html")


def feet(tab: Tab) -> list[list[float]]:
    places: list[list[float]] = tab.run(f"{REPLAY}.pose().feet")
    return places


def curve(tab: Tab, name: str) -> tuple[list[bool], str]:
    """Whether the curves of a name are shown in the first plot that has it, and the state of its button."""
    shown = tab.run(
        f"bigant.plots.filter(one => one.figure === {PLOT}).flatMap(one => one.model.renderers)"
        f".filter(one => one.name === '{name}').map(one => one.visible)"
    )
    return shown, tab.run(f"{button(name)}.getAttribute('aria-pressed')")


def button(name: str) -> str:
    """The button in the legend of the first plot."""
    return f"[...{PLOT}.querySelectorAll('.legend button')].find(b => b.textContent === '{name}')"


def slide(tab: Tab, share: float) -> None:
    """Click into the slider of the replay."""
    left, top, width, height = tab.place("document.querySelector('.controls input')")
    tab.press((left + share * width, top + height / 2))


def test_scrubbing_moves_the_robot_and_the_cursor_of_the_curves(walk: Tab) -> None:
    walk.until(DRAWN)
    before, picture = feet(walk), walk.run(f"{REPLAY}.canvas.toDataURL()")
    slide(walk, 0.9)
    t_s = walk.run(f"{REPLAY}.t")
    span = walk.run(f"[{REPLAY}.d.t[0], {REPLAY}.d.t[{REPLAY}.count - 1]]")
    assert t_s == pytest.approx(span[0] + 0.9 * (span[1] - span[0]), abs=0.03 * (span[1] - span[0]))
    assert np.abs(np.array(feet(walk)) - before).max() > 0.005
    assert walk.run(f"{REPLAY}.canvas.toDataURL()") != picture
    assert walk.run("document.querySelector('.controls output').textContent") == f"{t_s:.2f} s"
    cursors = walk.run(
        "bigant.plots.filter(o => o.time).map(o => { const box = o.view.frame.bbox, r = o.model.x_range;"
        "return [o.cursor.hidden, r.start + (r.end - r.start)"
        " * (parseFloat(o.cursor.style.left) - box.left) / box.width]; })"
    )
    assert cursors
    assert all(not hidden and at == pytest.approx(t_s, abs=0.01) for hidden, at in cursors)
    assert walk.errors == []


def test_a_click_on_a_curve_moves_the_robot_there(walk: Tab) -> None:
    walk.until(DRAWN)
    before = walk.run(f"{REPLAY}.t")
    left, top, width, height = walk.place("bigant.plots[0].cell")
    walk.press((left + 0.8 * width, top + height / 3))
    walk.until(f"{REPLAY}.t !== {before}")
    box = walk.run("(b => [b.left, b.width])(bigant.plots[0].view.frame.bbox)")
    span = walk.run("(r => [r.start, r.end])(bigant.plots[0].model.x_range)")
    share = (0.8 * width - box[0]) / box[1]
    expected = span[0] + share * (span[1] - span[0])
    assert walk.run(f"{REPLAY}.t") == pytest.approx(expected, abs=0.02 * (span[1] - span[0]))


def test_it_plays_and_pauses(walk: Tab) -> None:
    start = walk.run(f"{REPLAY}.t")
    walk.click("document.querySelector('.play')")
    assert walk.run("document.querySelector('.play').textContent") == "Pause"
    walk.until(f"{REPLAY}.t > {start} + 0.2")
    walk.click("document.querySelector('.play')")
    at = walk.run(f"{REPLAY}.t")
    assert walk.run(f"new Promise(done => setTimeout(() => done({REPLAY}.t), 60))") == at
    walk.run(f"{REPLAY}.canvas.focus()")
    walk.key("ArrowRight")
    assert walk.run(f"{REPLAY}.t") == pytest.approx(at + 0.1)


def test_dragging_turns_the_robot_and_a_view_turns_it_back(walk: Tab) -> None:
    left, top, width, height = walk.place(f"{REPLAY}.canvas")
    middle = (left + width / 2, top + height / 2)
    walk.press(middle, (middle[0] + 60, middle[1] + 20))
    turned = walk.run(f"[{REPLAY}.view.azimuth, {REPLAY}.view.elevation]")
    assert turned == pytest.approx([-55 - 30, 28 + 8], abs=0.6)
    walk.click(
        "[...document.querySelectorAll('.legend button')].find(b => b.textContent === '3-D')"
    )
    assert walk.run(f"[{REPLAY}.view.azimuth, {REPLAY}.view.elevation]") == [-55, 28]


def test_the_replay_is_the_log(walk: Tab, shown_walk: Path) -> None:
    """Feet on the page are where the robot file puts them at the log's angles and ground truth."""
    from model.kinematics.legs import leg_kinematics
    from record.log.blocks.read import read_log
    from robot.config.robot_file import parse_robot
    from robot.report.replay import kept_frames
    from robot.report.replay_still import rotation

    log = read_log(shown_walk)
    row = int(kept_frames(log.t_s)[30])
    walk.run(f"{REPLAY}.seek({REPLAY}.d.t[30])")
    angles = log.angle_rad[row]
    kinematics = leg_kinematics(parse_robot(log.config_text).parameters)
    own = kinematics.feet(angles, np.zeros_like(angles)).position_m
    expected = own @ rotation(log.truth_quaternion_xyzw[row]).T + log.truth_position_W[row]
    np.testing.assert_allclose(feet(walk), expected, atol=1e-4)
    tips = np.array(walk.run(f"{REPLAY}.pose().arrows.predicted"))
    force = (tips - expected) @ rotation(log.truth_quaternion_xyzw[row]) / 0.006
    np.testing.assert_allclose(force, log.predicted_force_n[row], atol=0.05)


def test_frames_that_are_added_bring_all_that_is_drawn(walk: Tab) -> None:
    """As a live view adds them: every array grows by as many frames."""
    rows = (
        f"Object.fromEntries(Object.entries({REPLAY}.d).filter(([, v]) => ArrayBuffer.isView(v))"
        ".map(([name, v]) => [name, v.length]))"
    )
    before = walk.run(rows)
    assert {"slip", "loaded", "points", "measured"} <= before.keys()
    walk.run(
        f"{REPLAY}.add(JSON.parse({REPLAY}.figure.querySelector('script').textContent), 100000)"
    )
    assert walk.run(rows) == {name: 2 * count for name, count in before.items()}
    assert walk.errors == []


def test_a_name_hides_its_curve_and_shows_it_again(walk: Tab) -> None:
    walk.until(DRAWN)
    shown, pressed = curve(walk, "predicted")
    assert shown
    assert (all(shown), pressed) == (True, "true")
    walk.click(button("predicted"))
    shown, pressed = curve(walk, "predicted")
    assert (any(shown), pressed) == (False, "false")
    assert all(curve(walk, "true")[0])
    walk.click(button("predicted"))
    assert all(curve(walk, "predicted")[0])


def test_a_drag_zooms_all_curves_over_time_and_a_double_click_goes_back(walk: Tab) -> None:
    walk.until(DRAWN)
    ranges = (
        "bigant.plots.filter(o => o.time).map(o => [o.model.x_range.start, o.model.x_range.end])"
    )
    whole = walk.run(ranges)
    left, top, width, height = walk.place("bigant.plots[0].cell")
    at = top + height / 2
    walk.press((left + 0.4 * width, at), (left + 0.5 * width, at), (left + 0.6 * width, at))
    walk.until(f"{ranges}[0][0] > {whole[0][0]} + 1")
    zoomed = walk.run(ranges)
    assert len({tuple(np.round(one, 6)) for one in zoomed}) == 1, "all together"
    assert zoomed[0][1] - zoomed[0][0] < 0.35 * (whole[0][1] - whole[0][0])
    walk.run("bigant.plots[0].cell.dispatchEvent(new MouseEvent('dblclick', {bubbles: true}))")
    walk.until(f"Math.abs({ranges}[1][0] - {whole[0][0]}) < 1e-6")


def test_curves_show_their_values_under_the_pointer(walk: Tab) -> None:
    walk.until(DRAWN)
    left, top, width, height = walk.place("bigant.plots[0].cell")
    walk.hover((left + 0.5 * width, top + 0.5 * height))
    words = walk.until(f"{PLOT}.querySelector('.readout').textContent")
    values = dict(re.findall(r"(\w+) (-?[\d.e-]+)(?:, |$)", words))
    assert words.startswith("time [s] ")
    assert {"true", "predicted", "estimator"} <= values.keys()
    t_s = float(words.split()[2].rstrip(":"))
    x, y = walk.run(
        "(d => [Array.from(d.x), Array.from(d.y)])"
        "(bigant.plots[0].model.renderers.find(r => r.name === 'true').data_source.data)"
    )
    assert float(values["true"]) == pytest.approx(np.interp(t_s, x, y), abs=0.5)


@pytest.mark.parametrize(
    ("name", "plots"), [("show", 20), ("odom", 20), ("robot", 10), ("model", 1)]
)
def test_a_page_is_light_and_fits_a_phone_without_an_error(
    browser: Tab, walk_pages: Path, name: str, plots: int
) -> None:
    page = walk_pages / f"{name}.html"
    assert page.stat().st_size < MOST_BYTES
    browser.show(SMALL_PX, touch=True).open(page)
    assert browser.run(ALL_DRAWN) >= plots
    scroll, width = browser.run(WIDE)
    assert scroll <= width == SMALL_PX
    assert browser.errors == []


def test_a_robot_file_is_a_robot_whose_legs_go_through_a_cycle(
    browser: Tab, walk_pages: Path
) -> None:
    from gaits.catalog import make_gait
    from robot.config.robot_file import load_robot
    from robot.design.gait_figures import walk_gait
    from robot.report.gait_replay import cycle_frames
    from robot.report.replay_still import rotation

    browser.show(1100).open(walk_pages / "robot.html")
    assert browser.run("document.querySelector('figure').className") == "replay live"
    robot = load_robot().parameters
    one = walk_gait(robot, make_gait("tripod", robot))
    made, row = cycle_frames(robot, one), 60
    browser.run(f"{REPLAY}.seek({REPLAY}.d.t[{row}])")
    expected = one.cycle.feet.position_m[row] @ rotation(made["turn"][row]).T + made["place"][row]
    np.testing.assert_allclose(feet(browser), expected, atol=2e-4)
    standing = one.cycle.answer.contact[row]
    np.testing.assert_allclose(expected[standing, 2], one.cycle.height_m[row][standing], atol=2e-3)
    phase = made["t"][row] / made["cycle_s"]
    assert (
        browser.run("document.querySelector('.controls output').textContent")
        == f"phase {phase:.2f}"
    )
    assert browser.run(f"{REPLAY}.d.names") == [
        f"{k} {n}" for k, n in enumerate(robot.legs.names, 1)
    ]
    picture = browser.run(f"{REPLAY}.canvas.toDataURL()")
    axes = "[...document.querySelectorAll('.legend button')].find(b => b.textContent === 'axes')"
    browser.click(axes)
    assert browser.run(f"{REPLAY}.canvas.toDataURL()") != picture
    slide(browser, 0.97)
    before = browser.run(f"{REPLAY}.t")
    browser.run("document.querySelector('.legend select').value = 10")
    browser.run("document.querySelector('.legend select').dispatchEvent(new Event('change'))")
    browser.click("document.querySelector('.play')")
    browser.until(f"{REPLAY}.t < {before}")  # a cycle goes round
    assert browser.run(f"{REPLAY}.playing") is True
    browser.click("document.querySelector('.play')")
    assert browser.errors == []


@pytest.mark.parametrize("name", ["show", "robot"])
def test_a_page_begins_with_its_picture_and_a_phone_has_the_sentence_with_it(
    browser: Tab, walk_pages: Path, name: str
) -> None:
    tops = (
        "['h1', 'figure', '.verdict', 'h2, .facts'].map("
        "one => document.querySelector(one).getBoundingClientRect().top)"
    )
    browser.show(1100).open(walk_pages / f"{name}.html")
    heading, picture, sentence, numbers = browser.run(tops)
    assert heading < picture < sentence < numbers
    browser.show(SMALL_PX, touch=True).open(walk_pages / f"{name}.html")
    heading, picture, sentence, numbers = browser.run(tops)
    assert heading < sentence < picture < numbers
    assert picture < 400


def test_in_the_dark_curves_and_axes_are_light(browser: Tab, walk_pages: Path) -> None:
    browser.show(1100, dark=True).open(walk_pages / "odom.html")
    browser.until(DRAWN)
    axis = browser.run("bigant.plots[0].model.below[0].major_label_text_color")
    assert axis == "#a6a6a6"
    black = browser.run(
        "bigant.plots.flatMap(o => o.model.renderers)"
        ".filter(r => r.glyph.line_color && r.glyph.line_color.value === '#000000').length"
    )
    assert black == 0


def test_on_paper_and_without_scripts_there_is_the_still_picture(
    browser: Tab, walk_pages: Path
) -> None:
    stills = (
        "[...document.querySelectorAll('figure')].every(f => f.querySelector('.still').offsetHeight > 0"
        " && !(f.querySelector('.moving') || {}).offsetHeight)"
    )
    browser.show(800, paper=True).open(walk_pages / "show.html")
    browser.until("document.querySelector('figure.replay').classList.contains('live')")
    assert browser.run(stills) is True
    browser.show(800).open(walk_pages / "show.html", scripts=False)
    assert browser.run(stills) is True
    assert browser.run("document.body.innerText.includes('forward while walking')") is True


@pytest.fixture(scope="module")
def gap_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a servo that is late, has play and a wrong zero: three causes."""
    folder, paths = tmp_path_factory.mktemp("gap"), []
    for number in range(4):
        rng, t_s = np.random.default_rng(number), np.arange(1000) / 50.0
        command = 0.6 * np.sin(2 * np.pi * (0.15 + 0.05 * number) * t_s)
        shaft = play(np.interp(t_s - 0.06, t_s, command), 0.03, 0.0) + 0.02
        shaft += 0.001 * rng.standard_normal(len(t_s))
        paths.append(str(folder / f"run{number}.csv"))
        write_trial(servo_trial(IDEAL, command, shaft), Path(paths[-1]))
    page = folder / "gap.html"
    assert cli.run(["gap", "diagnose", *paths, "--jobs", "1", "--html", str(page)]) == 0
    return page


def drawn_curve(tab: Tab, name: str) -> list[float]:
    values: list[float] = tab.run(
        f"Array.from(bigant.plots[0].model.renderers.find(r => r.name === '{name}').data_source.data.y)"
    )
    return values


def rms_shown(tab: Tab) -> list[float]:
    """RMS difference without any cause, and with those that are on."""
    words = tab.run("document.querySelector('.left').textContent")
    return [float(one) for one in re.findall(r"(\d+\.\d+) with", words)]


def test_causes_are_switched_off_and_on_again(browser: Tab, gap_page: Path) -> None:
    browser.show(1100).open(gap_page).until(DRAWN)
    whole, before = (
        drawn_curve(browser, "with the causes"),
        drawn_curve(browser, "simulator before"),
    )
    none, all_on = rms_shown(browser)
    assert all_on < 0.2 * none
    count = browser.run("document.querySelectorAll('.switches input').length")
    assert count == 3
    left = [all_on]
    for number in range(count):
        browser.click(f"document.querySelectorAll('.switches input')[{number}]")
        left.append(rms_shown(browser)[1])
        assert drawn_curve(browser, "with the causes") != whole
    assert left == sorted(left)
    assert left[-1] == none, "no cause is on"
    np.testing.assert_allclose(drawn_curve(browser, "with the causes"), before, rtol=1e-6)
    for number in range(count):
        browser.click(f"document.querySelectorAll('.switches input')[{number}]")
    assert drawn_curve(browser, "with the causes") == whole
    assert rms_shown(browser) == [none, all_on]
    assert browser.errors == []


def test_the_page_of_a_diagnosis_is_light_and_fits_a_phone(browser: Tab, gap_page: Path) -> None:
    assert gap_page.stat().st_size < MOST_BYTES / 3
    browser.show(SMALL_PX, touch=True).open(gap_page)
    assert browser.run(ALL_DRAWN) >= 1
    scroll, width = browser.run(WIDE)
    assert scroll <= width == SMALL_PX
    assert browser.errors == []
    browser.show(SMALL_PX).open(gap_page, scripts=False)
    assert browser.run("document.querySelector('.still').offsetHeight > 0") is True
