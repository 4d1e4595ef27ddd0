"""Every HTML report in a headless Chromium, without its scripts: drawn, fit for a phone and for paper."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread as read_png

from drivers.dynamixel.condition import ServoCondition
from model.values.faults import StopReason
from robot.bringup.preflight.finding import (
    SERVOS,
    Finding,
    about,
    failed,
    in_part,
    passed,
    skipped,
    warned,
)
from robot.bringup.preflight.loop import LoopFigures
from robot.bringup.preflight.page import CheckedRobot, check_page, leg_states
from robot.bringup.preflight.servo_figures import ServoFigures
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.report.page import Section, render, report_page
from robot.report.pictures import inline_svg, pictures
from robot.report.plan_view import PlanState
from robot.study.figure_catalog import TITLE, Drawn, Entry
from tests.robot.browser import (
    DESK_PX,
    PHONE_PX,
    Seen,
    find_browser,
    look_at,
    run_browser,
    without_scripts,
)
from tests.robot.gap_report.test_gap_diagnose import write_bench

needs_browser = pytest.mark.skipif(
    not find_browser(), reason="there is no Chromium on this computer"
)

LOOP = LoopFigures(
    10.0, 1000, 0, 3, (0.1, 0.3, 0.9, 6.1), (1.1, 1.4, 1.9, 3.0), 1.2, 0.8, StopReason.COMPLETED
)
DATE = "2026-02-03 04:05:06 UTC"
LONG = "there is no port /dev/serial/by-id/usb-FTDI_USB__-__Serial_Converter_FT4TCX1R-if00-port0"


def pre_flight(port: str, *findings: Finding, loops: tuple[LoopFigures, ...] = ()) -> str:
    """The page of these findings about servos of which two answered, and whose bus lost one read."""
    robot = CheckedRobot(load_robot(), port, "mine.toml")
    told = [(1200 + k, k + 1, leg) for k, leg in enumerate(("HL", "ML"))]
    conditions = [ServoCondition(leg, one, 321, 45, 4, 0, 0, 52, False, 0, volt / 100, 31.0)
                  for volt, one, leg in told]  # fmt: skip
    servos = ServoFigures(conditions, [2.9, 3.0, 9.0], [True, True, False], 10.0, 2.2)
    return check_page(robot, list(in_part(SERVOS, findings)), loops, servos, date=DATE)


def written(path: Path, *words: str) -> str:
    """The page that a command writes."""
    assert cli.run([*words, str(path)]) == 0
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def pages(walk_pages: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Every kind of report, from real data where the data are quick to get."""
    folder = tmp_path_factory.mktemp("pages")
    findings = [
        passed("disk", "78 GB free"),
        warned("load", "4.1 programs want to run on 2 processors", "close some"),
        failed("port", LONG, "plug it in or choose another port with --hardware PORT"),
        skipped("watchdog", "torque stays off without --armed"),
    ]
    picture = Figure(figsize=(3, 2))
    picture.subplots().plot([0, 1])
    picture.savefig(folder / "picture.png")
    drawn = Drawn(picture, "Its caption.", ("a  b",) * 3)
    return {
        **{name: (walk_pages / f"{name}.html").read_text("utf-8")
           for name in ("show", "odom", "robot", "model")},
        "gap": written(folder / "gap.html", "gap", "diagnose", *write_bench(folder, 0.03),
                       "--jobs", "1", "--html"),
        "check": pre_flight("/dev/ttyUSB0", *findings, loops=(LOOP,)),
        "figures": render("figures.html", title=TITLE, source="From a walk.", entries=[
            (Entry("picture", "A picture", "fig. 1", lambda _: drawn), drawn,
             (folder / "picture.png").as_uri())]),
        "matrix": matrix(),
    }  # fmt: skip


def framed(body: str) -> str:
    """A page with the common frame and style around markup of a test's own."""
    return render("frame.html", title="t").replace("<body>", f"<body>{body}")


def matrix() -> str:
    from benchmarks.faults.matrix import committed, matrix_page

    return matrix_page(committed())


@pytest.fixture(scope="module")
def still(pages: dict[str, str]) -> dict[str, str]:
    """As a reader without scripts has them; test_moving_pages.py has those with."""
    return {name: without_scripts(page) for name, page in pages.items()}


@pytest.fixture(scope="module")
def on_phone(still: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Seen]:
    return look_at(still, tmp_path_factory.mktemp("phone"), PHONE_PX)


@pytest.fixture(scope="module")
def on_desk(still: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Seen]:
    return look_at(still, tmp_path_factory.mktemp("desk"), DESK_PX)


def both(request: pytest.FixtureRequest) -> Iterator[tuple[str, Seen]]:
    for where in ("on_phone", "on_desk"):
        for name, seen in request.getfixturevalue(where).items():
            yield f"{name} {where}", seen


@pytest.mark.soak
@needs_browser
def test_pages_have_an_empty_console_and_all_pictures(request: pytest.FixtureRequest) -> None:
    for name, seen in both(request):
        assert seen.errors == (), name
        assert seen.empty == 0, name
        assert seen.letters > 100, name
    seen = request.getfixturevalue("on_phone")
    assert {name: one.pictures > 0 for name, one in seen.items()} == {
        "show": True, "odom": True, "model": True, "gap": True, "figures": True,
        "robot": True, "check": True, "matrix": False,
    }  # fmt: skip


@pytest.mark.soak
@needs_browser
def test_nothing_stands_out_of_a_phone(request: pytest.FixtureRequest) -> None:
    for name, seen in both(request):
        assert seen.wide == (), name
        assert seen.scroll_px <= seen.width_px, name


@pytest.mark.soak
@needs_browser
def test_no_verdict_and_no_number_is_broken_over_two_lines(request: pytest.FixtureRequest) -> None:
    for name, seen in both(request):
        assert seen.broken == (), name


@pytest.mark.soak
@needs_browser
def test_no_text_lies_on_another(request: pytest.FixtureRequest) -> None:
    for name, seen in both(request):
        assert seen.overlaps == (), name


@pytest.mark.soak
@needs_browser
def test_what_is_wrong_with_a_page_is_seen(tmp_path: Path) -> None:
    """The tests above can fail: a page with each fault is found out."""
    bad = framed(
        "<h1>bad</h1>"
        "<p style='width:900px'>too wide</p>"
        "<table><tr><td class='short' style='white-space:normal;max-width:1em'>3 mm</td></tr></table>"
        "<img src='nothing.png'>"
        "<svg viewBox='0 0 100 50'><rect width='90' height='40'/><text x='5' y='20'>one</text>"
        "<text x='6' y='21'>two</text></svg>"
        "<script>nothing()</script>"
    )
    seen = look_at({"bad": bad}, tmp_path, PHONE_PX)["bad"]
    assert [words for words in seen.errors if "nothing is not defined" in words]
    assert [words for words in seen.errors if "not loaded" in words]
    assert seen.overlaps == ("one | two",)
    assert seen.broken == ("3 mm",)
    assert seen.empty == 1
    assert any(words.startswith("P") for words in seen.wide)
    assert seen.scroll_px > seen.width_px


@pytest.mark.soak
@needs_browser
def test_pages_are_dark_where_the_reader_wants_it(pages: dict[str, str], tmp_path: Path) -> None:
    switch = "--blink-settings=preferredColorScheme=0"
    light = look_at({"check": pages["check"]}, tmp_path, PHONE_PX)["check"]
    dark = look_at({"check": pages["check"]}, tmp_path, PHONE_PX, switch)["check"]
    assert (light.ink, light.paper) == ("rgb(26, 26, 26)", "rgb(255, 255, 255)")
    assert (dark.ink, dark.paper) == ("rgb(232, 232, 232)", "rgb(22, 24, 27)")


@pytest.mark.soak
@needs_browser
def test_pages_print(pages: dict[str, str], tmp_path: Path) -> None:
    page, out = tmp_path / "show.html", tmp_path / "show.pdf"
    page.write_text(pages["show"], encoding="utf-8")
    run_browser(tmp_path, f"--print-to-pdf={out}", "--no-pdf-header-footer", page.as_uri())
    assert out.read_bytes().startswith(b"%PDF")
    assert 20_000 < out.stat().st_size < 2_000_000


@pytest.mark.soak  # its pages are made there anyway, and take eight seconds
def test_pages_share_one_frame_and_load_nothing(
    pages: dict[str, str], still: dict[str, str]
) -> None:
    style = {page[page.index("<style>") : page.index("h1 {")] for page in pages.values()}
    assert len(style) == 1
    for name, page in still.items():
        assert page.startswith("<!doctype html>\n<html lang='en'>"), name
        assert "http://" not in page.replace("http://www.w3.org/", "").replace(
            "http://purl.org/", ""
        ).replace("http://creativecommons.org/", ""), name
        assert len(page) < 1_000_000, name
        sources = set(re.findall(r"<script[^>]*src=['\"]([^'\"]*)", pages[name]))
        assert not sources, name
        assert ("Bokeh" in pages[name]) == ("<figure class='plot'>" in page), name


def test_text_of_a_picture_stays_text_and_pages_do_not_change_from_run_to_run() -> None:
    def page() -> str:
        figure = Figure()
        figure.subplots().plot(np.arange(3), label="a curve")
        figure.legend()
        return report_page("t", "n", [Section("", [("a", "<b>")]), *pictures({"One": figure})])

    assert page() == page()
    assert ">a curve</text>" in page()
    assert "&lt;b&gt;" in page()


def test_verdicts_in_a_table_are_marked_and_numbers_set_right() -> None:
    rows = [("fail", "a & b", "3"), ("", "", "0.67 s")]
    table = report_page("t", "", [Section("", rows, ("", "what", "n"), (2,))])
    assert "<td class='number short'>0.67 s</td>" in table
    assert "<td class='fail'>fail</td>" in table
    assert "a &amp; b" in table
    assert "<td class='number'>3</td>" in table
    assert "<td" not in report_page("t", "", [Section("empty", [], ("a",))])
    assert "empty" not in report_page("t", "", [Section("empty", [], ("a",))])


@pytest.mark.usefixtures("words_only")
def test_a_page_of_the_pre_flight_says_what_to_do_first() -> None:
    page = pre_flight("virtual", failed("port", "absent", "plug it in"))
    assert page.index("Not fit to walk: port") < page.index("plug it in") < page.index("absent")
    assert f"{DATE}; virtual devices; robot file mine.toml" in page
    assert "Fit to walk. 1 passed, 0 warned" in pre_flight("virtual", passed("port", "there"))


def test_a_page_of_the_pre_flight_begins_with_the_robot_and_then_one_sentence() -> None:
    page = pre_flight("virtual", about(["ML"], failed("voltage", "ML has 9 V", "charge it")))
    assert page.index("<svg") < page.index("class='verdict") < page.index("Servos in numbers")
    for words in (
        ">robot from above<",
        ">31 °C<",
        ">failed<",
        ">not checked<",
        "9.00 ms",
        "3.00 ms",
    ):
        assert words in page, words
    assert "3, 1 without an answer of every servo" in page


def test_a_leg_is_as_good_as_the_worst_that_was_found_about_it() -> None:
    findings = [
        about(["ML", "HL"], warned("return delay", "250 us", "set it to 0")),
        about(["ML"], failed("voltage", "9 V", "charge it")),
        passed("torque", "off"),
    ]
    names = ("HL", "ML", "FL", "HR")
    assert leg_states(names, findings, {"HL", "ML", "FL"}) == [
        PlanState.WARNED, PlanState.BAD, PlanState.GOOD, PlanState.UNKNOWN,
    ]  # fmt: skip


def test_a_page_that_cannot_be_written_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["check", "--html", str(tmp_path / "a.txt")]) == 2
    assert "must end in .html" in capsys.readouterr().err


def test_a_picture_is_in_the_page_s_colours_and_leaves_the_page_behind_it() -> None:
    figure = Figure()
    ax = figure.subplots()
    ax.plot([0, 1], color="#000000", label="a curve")
    ax.plot([1, 0], color="#0072b2")
    ax.legend()
    svg = inline_svg(figure, "0")
    assert "#000000" not in svg
    assert "#ffffff" not in svg.lower()
    assert "stroke: currentColor" in svg
    assert "stroke: #0072b2" in svg, "a colour that means something stays"


@pytest.mark.soak
@needs_browser
def test_what_goes_on_behind_an_edge_has_a_shade_there(
    pages: dict[str, str], tmp_path: Path
) -> None:
    """The shade is behind the content, so a picture of the page's edge differs from its paper."""
    shot = tmp_path / "shot.png"
    wide = "<div class='scroll'><p style='width:2000px;height:300px'></p></div>"
    page = tmp_path / "page.html"
    page.write_text(framed(wide), encoding="utf-8")
    run_browser(tmp_path, f"--screenshot={shot}", f"--window-size={DESK_PX},400", page.as_uri())
    row = read_png(shot)[150, :, 0]
    inside = np.flatnonzero(row < 0.98)
    assert len(inside) > 5, "a shade"
    assert inside.min() > len(row) / 2, "at the right edge only: there is nothing to the left"
