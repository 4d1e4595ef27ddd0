"""What the page and the terminal say of a diagnosis, and how it is drawn."""

import re
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from gap.detectable import Detectable
from gap.diagnosis.alternatives.ambiguity import OpenRival
from gap.diagnosis.alternatives.probability import RivalCause
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, TrialFaults, Verdict
from gap.diagnosis.answer.verdict import verdict_of
from gap.diagnosis.comparison.joint_ranking import JointGap
from gap.diagnosis.comparison.trend import RunChange
from gap.diagnosis.diagnose import diagnose
from gap.experiments.next_run import NextRun
from gap.interfaces import DataFault
from gap.machines.servo_bench.simulator import servo_bench
from record.trial.trial import read_trial
from robot.gap_report.page import diagnosis_page, draw_traces
from robot.gap_report.page_map import BLACK_FROM
from robot.gap_report.summary import LOOK_THERE, TO_APPLY, summary_lines
from robot.gap_report.words import file_words, machine_words, size_words, stage_note
from tests.robot.browser import without_scripts
from tests.robot.gap_report.test_gap_diagnose import write_bench

FILES = tuple(Path(f"run{number}.csv") for number in range(4))
SUBJECT = ("bench, joint arm", date(2026, 2, 3), FILES)
PLAY = ("play", ("arm",))


def bench_diagnosis(folder: Path, width: float) -> Diagnosis:
    trials = [read_trial(Path(path)) for path in write_bench(folder, width)]
    return diagnose(trials, servo_bench(trials))


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return bench_diagnosis(tmp_path_factory.mktemp("play"), 0.03)


@pytest.fixture(scope="module")
def nothing(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return bench_diagnosis(tmp_path_factory.mktemp("healthy"), 0.0)


CHANGE = RunChange(
    "friction_level", (), "friction", "ratio", "", -0.1, 0.002, "Clean the feet.",
    (("foot_friction", ("FL",)),),
)  # fmt: skip


def test_what_changes_while_the_machine_runs_is_said_with_what_to_do(nothing: Diagnosis) -> None:
    d = replace(nothing, verdict=Verdict.UNEXPLAINED, stage="friction", change=CHANGE, causes=())
    said = " ".join(" ".join(summary_lines(d, FILES)).split())
    changes = "friction_level, or foot_friction at FL changes while the machine runs"
    assert f"There is a gap in the stage friction: {changes}" in said
    assert f"which: none by its mean; {changes}" in said
    assert "what to do, before and after a run: Clean the feet." in said
    assert "ratio by about -0.1 from start to end" in said
    assert "reduces it" not in said
    assert LOOK_THERE not in said
    page = without_scripts(diagnosis_page(d, *SUBJECT))
    assert f"None by its mean; {changes}" in page
    assert "reduces it" not in page


@pytest.fixture(scope="module")
def two(found: Diagnosis) -> Diagnosis:
    """Two causes, one of which has an open rival."""
    one = found.causes[0]
    causes = (one, replace(one, effect="encoder_scale"))
    return replace(
        found, verdict=Verdict.AMBIGUOUS, causes=causes,
        ambiguous=(OpenRival(0, "backlash", ("arm",), 0.3, 1.0, 1.0, PLAY, "backlash", 4.0),),
        rivals=(
            RivalCause(0, "backlash", ("arm",), 0.3, 1.0, 1.0, PLAY, "backlash"),
            RivalCause(1, "play", ("arm",), 0.2, 1.0, 1.0, ("encoder_scale", ("arm",)), "play"),
        ),
    )  # fmt: skip


def plain(page: str) -> str:
    """The page's text without its style."""
    return re.sub(r"<[^>]*>", " ", page[page.index("<body>") :])


@pytest.mark.usefixtures("words_only")
def test_without_a_gap_there_are_no_shares_of_one(nothing: Diagnosis) -> None:
    assert nothing.verdict is Verdict.NO_GAP
    page = diagnosis_page(nothing, *SUBJECT)
    text = plain(page)
    assert "<title>No gap | bench, joint arm | run0.csv, run1.csv, run2.csv and 1 more" in page
    assert "Nothing stands out." in text
    assert "times expected" in text
    for words in ("of the gap", "Before and after", "Where it lies"):
        assert words not in text
    assert "class='bar'" not in page


@pytest.mark.usefixtures("words_only")
def test_with_a_gap_title_and_head_say_what_where_and_of_which_files(found: Diagnosis) -> None:
    page = diagnosis_page(found, *SUBJECT)
    assert "<title>Explained: play at arm | bench, joint arm | run0.csv" in page
    text = plain(page)
    for words in (
        "bench, joint arm.",
        "2026-02-03",
        "of its energy above the baseline",
        "RMS difference",
    ):
        assert words in text
    assert "of each joint in each third of the run" in text
    assert " leg " not in text
    assert "gait" not in text


def test_many_files_are_counted() -> None:
    assert file_words([Path(f"toss{n}.parquet") for n in range(114)]) == (
        "toss0.parquet, toss1.parquet, toss2.parquet and 111 more"
    )


def test_a_machine_without_a_name_is_called_by_its_file(tmp_path: Path) -> None:
    trial = read_trial(Path(write_bench(tmp_path, 0.0, 1)[0]))
    assert machine_words(trial) == "bench, joint arm"
    named = replace(trial.header, robot_text=f'name = "Rig 2"\n{trial.header.robot_text}')
    assert machine_words(replace(trial, header=named)) == "Rig 2, joint arm"


@pytest.mark.usefixtures("words_only")
def test_each_rival_is_said_with_its_cause(two: Diagnosis) -> None:
    assert two.sentence.endswith("These runs cannot distinguish play at arm from backlash at arm.")
    rows = re.findall(
        r"<td>([^<]*)</td><td>([^<]*)</td><td>0\.\d\d</td>", diagnosis_page(two, *SUBJECT)
    )
    # play was named itself, so it stands in the place of no other
    assert rows == [("play at arm", "backlash at arm")]


@pytest.mark.usefixtures("words_only")
def test_one_run_judged_by_its_own_end_is_not_called_a_held_out_run(found: Diagnosis) -> None:
    d = replace(found, fitted_trials=(0,), held_out_trials=(0,))
    assert "on the last third of the run" in d.sentence
    for text in (plain(diagnosis_page(d, *SUBJECT)), "\n".join(summary_lines(d, FILES))):
        assert "the last third of the run (run0.csv)" in text
        assert "held-out run" not in text
    assert "on a held-out run" in found.sentence


@pytest.mark.usefixtures("words_only")
def test_a_cause_that_shows_in_other_stages_is_explained_once(found: Diagnosis) -> None:
    silent, loud = (
        next(s for s in found.where.stages if bool(np.isnan(s.own)) is seen)
        for seen in (True, False)
    )
    unseen = replace(found, causes=(replace(found.causes[0], stage=silent.stage),))
    assert "has no channel of its own" in stage_note(unseen)
    stages = tuple(replace(s, share=0.0) if s is loud else s for s in found.where.stages)
    apart = replace(found, where=replace(found.where, stages=stages),
                    causes=(replace(found.causes[0], stage=loud.stage, shrink=0.42),))  # fmt: skip
    note = stage_note(apart)
    assert note.startswith(f"play at arm explains 42%, its stage {loud.stage} has 0%: ")
    assert note in plain(diagnosis_page(apart, *SUBJECT))
    assert note.split()[0] in "\n".join(summary_lines(apart, FILES))
    own = replace(found, causes=(replace(found.causes[0], stage=loud.stage),))
    assert stage_note(own) == ""


SWAPPED = DataFault("swapped", "shaft_arm_rad", "follows the command of leg and not its own", True)
LONE = DataFault("spikes", "current_arm_a", "1 lone sample stands out by 3", False)


@pytest.mark.usefixtures("words_only")
@pytest.mark.parametrize("verdict", [Verdict.EXPLAINED, Verdict.NO_GAP])
def test_severe_faults_of_the_data_come_first_and_no_cause_sounds_sure(
    found: Diagnosis, verdict: Verdict
) -> None:
    ill = replace(
        found, verdict=verdict, data_faults=(TrialFaults(1, (LONE, SWAPPED)),), next=(next_run(0),)
    )
    lines = summary_lines(ill, FILES)
    assert lines[0] == "FIX THE DATA FIRST"
    assert lines[1] == "severe faults of the data:"
    assert lines[2].startswith("  1. swapped shaft_arm_rad in run1.csv: follows the command of leg")
    assert lines[3].startswith("     what to do: exchange the columns in the column map")
    text = "\n".join(lines)
    assert text.index("other data faults:") > text.index("With the data as they are:")
    page = plain(diagnosis_page(ill, *SUBJECT))
    assert page.index("Severe faults of the data") < page.index("With the data as they are")
    assert page.index("exchange the columns") < page.index("With the data as they are")
    assert "<title>Fix the data first: shaft_arm_rad |" in diagnosis_page(ill, *SUBJECT)
    for words in (text, page):
        assert "The simulator lacks" not in words
        assert "to run next" not in words
        assert found.causes[0].remedy not in words, "nobody acts on a cause that may be none"
    assert ill.sentence.startswith(
        "Fix the data first (shaft_arm_rad): what follows cannot be trusted. With the data as they are: "
    )
    assert diagnosis_json(ill)["severe_data_faults"] == ["shaft_arm_rad"]
    mild = replace(found, data_faults=(TrialFaults(1, (LONE,)),))
    assert summary_lines(mild, FILES)[0] == "EXPLAINED"
    assert mild.sentence == found.sentence


def test_legs_are_not_ranked_by_a_channel_that_they_do_not_have(found: Diagnosis) -> None:
    joints = (
        JointGap("L1_yaw", 0.8, "shaft_error", 0.2, "rad"),
        JointGap("L1", 0.2, "force_z", 0.3, "N"),
        JointGap("L2", 0.0, "force_z", np.nan, "N"),
    )
    lines = summary_lines(replace(found, where=replace(found.where, joints=joints)), FILES)
    assert "  by shaft_error: L1_yaw 80% (0.2 rad)" in lines
    assert "  by force_z: L1 20% (0.3 N), L2 0%" in lines
    assert "nan" not in "\n".join(lines)


@pytest.mark.usefixtures("words_only")
def test_why_nothing_is_known_of_how_far_is_the_true_reason(found: Diagnosis) -> None:
    unknown = replace(found.far, shrink=np.nan, low=np.nan, high=np.nan)

    def words(d: Diagnosis) -> str:
        return next(line for line in summary_lines(d, FILES, 400) if line.startswith("how far: "))

    none = replace(found, verdict=Verdict.UNEXPLAINED, causes=(), far=unknown)
    assert words(none).startswith("how far: no cause is named, so nothing is explained; RMS ")
    assert "too small" in words(replace(found, far=unknown))
    broken = replace(found, far=replace(unknown, after=np.nan))
    assert "the simulation with the named cause breaks down" in words(broken)
    page = plain(without_scripts(diagnosis_page(broken, *SUBJECT)))
    assert "not known" in page
    assert not re.search(r"\bnan\b", page)
    worse = replace(found, far=replace(found.far, shrink=-0.02, low=-0.03, high=-0.01))
    assert "is predicted no better with the named cause" in words(worse)
    assert "does not improve the prediction of held-out runs" in worse.sentence


def test_a_sentence_of_several_causes_is_a_sentence(found: Diagnosis, two: Diagnosis) -> None:
    one = found.causes[0]
    three = tuple(replace(one, effect=name, form=name, values=()) for name in ("a", "b", "c"))
    d = replace(found, verdict=Verdict.UNEXPLAINED, causes=three)
    assert "; a at arm, b at arm and c at arm come closest and explain " in d.sentence
    assert " comes closest and explains " in replace(d, causes=three[:1]).sentence
    doubt = (replace(two.ambiguous[0], of=("b", ("arm",))),)
    sure = replace(d, verdict=Verdict.EXPLAINED, causes=three[:2], ambiguous=doubt)
    assert "lacks a at arm; adding all named causes explains " in sure.sentence


def test_the_command_that_applies_a_diagnosis_names_its_file(found: Diagnosis) -> None:
    legged = replace(found, simulator="legged")
    written = summary_lines(legged, FILES, json=Path("my runs/d.json"))
    assert "  bigant gap apply 'my runs/d.json'" in written
    assert "write the diagnosis with --json" not in "\n".join(written)
    for nowhere in (None, Path("-")):
        lines = summary_lines(legged, FILES, json=nowhere)
        assert TO_APPLY in lines


@pytest.mark.parametrize(
    ("size", "neutral", "lower", "upper", "unit", "words"),
    [
        (0.09, 1.0, 0.1, 3.0, "", "0.910 or 1.090"),
        (21.1, 0.0, -1.5, 1.5, "", "not detectable within its bounds (-1.5 to 1.5)"),
        (0.0123, 0.0, 0.0, 0.2, "s", "0.0123 s"),
        (0.0123, 0.0, -0.2, 0.2, "m", "+-0.0123 m"),
        (1.2, 1.0, 0.1, 3.0, "", "2.2"),
        (np.inf, 1.0, 0.1, 3.0, "", "these runs cannot show it"),
    ],
)
def test_sizes_are_values_that_make_sense(
    size: float, neutral: float, lower: float, upper: float, unit: str, words: str
) -> None:
    assert size_words(Detectable("e", "p", size, unit, neutral, lower, upper)) == words


@pytest.mark.usefixtures("words_only")
def test_a_size_beyond_the_bounds_is_no_size_anywhere(nothing: Diagnosis) -> None:
    one = Detectable("hip_mount_offset", "x_m", 0.064, "m", 0.0, -0.05, 0.05)
    d = replace(nothing, detectable=(one, replace(one, parameter="y_m", size=0.04)))
    on_screen, page = "\n".join(summary_lines(d, FILES)), plain(diagnosis_page(d, *SUBJECT))
    assert "not detectable at any size that makes sense: hip_mount_offset x_m" in on_screen
    assert "not detectable within its bounds (-0.05 to 0.05 m)" in page
    assert "0.064" not in on_screen + page
    assert [one["values"] for one in diagnosis_json(d)["detectable"]] == [[], [-0.04, 0.04]]


def test_the_terminal_says_how_many_sizes_it_leaves_out(nothing: Diagnosis) -> None:
    one = Detectable("effect", "p", 0.1, "", 1.0, 0.0, 2.0)
    lines = summary_lines(replace(nothing, detectable=(one,) * 15), FILES)
    assert "  all sizes are in --html and --json" in lines
    assert sum(line.startswith("  effect") for line in lines) == 12
    few = summary_lines(replace(nothing, detectable=(one,) * 3), FILES)
    assert not any("--html and --json" in line for line in few)


def test_the_terminal_has_no_sizes_joint_by_joint(nothing: Diagnosis) -> None:
    one = Detectable("play", "width_rad", 0.1, "rad", 0.0, 0.0, 2.0)
    each = replace(one, effect="play_at_every_joint", parameter="width_rad@elbow")
    text = "\n".join(summary_lines(replace(nothing, detectable=(one, each)), FILES))
    assert "play" in text
    assert "at_every_joint" not in text
    assert "all sizes are in --html and --json" in text


def test_what_could_hide_best_is_listed_first(nothing: Diagnosis) -> None:
    plain = Detectable("plain", "p", 0.1, "", 1.0, 0.0, 2.0)
    hidden = Detectable("hidden", "p", 0.5, "m", 0.0, -0.6, 0.6, "waist")
    never = Detectable("never", "p", 9.0, "", 1.0, 0.0, 2.0)
    lines = summary_lines(replace(nothing, detectable=(plain, hidden, never)), FILES)
    head = next(i for i, one in enumerate(lines) if one.startswith("smallest sizes"))
    assert lines[head + 1].split() == ["hidden", "at", "waist", "p", "+-0.5", "m"]
    assert lines[head + 2].split()[0] == "plain"
    assert lines[head + 3] == "not detectable at any size that makes sense: never p"


def next_run(number: int, pair: tuple[str, str] = ("delay", "lag"), limits: str = "") -> NextRun:
    return NextRun(
        f"run {number}", pair, 30.0, 1, 0.8, limits, "bigant drive --gait tripod --steer 0.5"
    )


@pytest.mark.usefixtures("words_only")
def test_the_best_runs_are_shown_with_their_pair_once(two: Diagnosis) -> None:
    page = diagnosis_page(replace(two, next=tuple(map(next_run, range(8)))), *SUBJECT)
    assert page.count("delay from lag") == 1
    assert "run 4" in page
    assert "run 5" not in page
    assert "3 more in --json" in page
    assert "<span>--gait</span> <span>tripod</span>" in page
    assert "caution" not in page
    assert page.index("Where it lies") < page.index("What to run next")
    mixed = (next_run(0), next_run(1, ("delay", "skew"), "weigh it"))
    page = diagnosis_page(replace(two, next=mixed), *SUBJECT)
    assert "delay from lag" in page
    assert "delay from skew" in page
    assert "caution" in page


@pytest.mark.parametrize("width", [60, 80, 100])
def test_no_line_but_a_command_is_wider_than_the_terminal(two: Diagnosis, width: int) -> None:
    d = replace(two, next=(next_run(0, ("a cause " * 9, "another")),), warnings=("word " * 40,))
    lines = summary_lines(d, FILES, width)
    text = [line for line in lines if not line.lstrip().startswith("bigant ")]
    assert 0.8 * width < max(map(len, text)) <= width
    assert not [line for line in text if line.endswith("+-") or line.lstrip().startswith("+-")]


def test_what_is_not_compared_is_grey(found: Diagnosis) -> None:
    def labels(d: Diagnosis) -> list[str]:
        (figure,) = draw_traces(d).values()
        return [text.get_text() for text in figure.legends[0].get_texts()]

    (trace,) = found.far.traces
    half = np.arange(len(trace.time_s)) < len(trace.time_s) // 2
    whole = replace(trace, compared=np.ones_like(half))
    assert "not compared" not in labels(replace(found, far=replace(found.far, traces=(whole,))))
    part = replace(found, far=replace(found.far, traces=(replace(trace, compared=half),)))
    assert "not compared" in labels(part)


def luminance(colour: np.ndarray) -> float:
    share = colour / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: np.ndarray, other: np.ndarray) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize(
    ("ink", "paper"), [((26, 26, 26), (255, 255, 255)), ((232, 232, 232), (22, 24, 27))]
)
def test_letters_of_the_map_can_be_read_on_every_colour(
    ink: tuple[int, ...], paper: tuple[int, ...]
) -> None:
    hot = np.array([213.0, 94.0, 0.0])
    for heat in np.linspace(0.0, 1.0, 101):
        cell = heat * hot + (1.0 - heat) * np.array(paper)
        letters = np.array(ink if heat <= BLACK_FROM else (0, 0, 0))
        assert contrast(letters, cell) > 4.0, heat


@pytest.mark.parametrize(
    ("share", "verdict", "sentence"),
    [
        (0.02, Verdict.EXPLAINED, "Of this, 2% may be encoder_scale at arm"),
        (-0.01, Verdict.EXPLAINED, " is named too, but does not improve the prediction of held-out runs:"),
        (0.2, Verdict.AMBIGUOUS, "These runs cannot distinguish encoder_scale at arm from backlash at arm"),
        (np.nan, Verdict.AMBIGUOUS, "These runs cannot distinguish encoder_scale at arm"),
    ],
)  # fmt: skip
def test_a_cause_that_explains_next_to_nothing_does_not_make_the_whole_ambiguous(
    two: Diagnosis, share: float, verdict: Verdict, sentence: str
) -> None:
    causes = (replace(two.causes[0], shrink=0.9 - share), replace(two.causes[1], shrink=share))
    doubt = (replace(two.ambiguous[0], of=("encoder_scale", ("arm",))),)
    assert verdict_of(True, causes, 0.0, doubt) is verdict
    d = replace(two, verdict=verdict, causes=causes, ambiguous=doubt)
    assert sentence in d.sentence
    lines = "\n".join(summary_lines(d, FILES))
    assert "indistinguishable from encoder_scale at arm: backlash at arm" in lines
    assert ("what to do about encoder_scale at arm:" in lines) == (verdict is Verdict.AMBIGUOUS)


@pytest.mark.usefixtures("words_only")
def test_nothing_is_to_be_done_about_what_is_hardly_a_cause(found: Diagnosis) -> None:
    cause = found.causes[0]
    for probability, followed in ((0.05, False), (0.8, True)):
        one = replace(cause, probability=probability)
        d = replace(found, verdict=Verdict.UNEXPLAINED, causes=(one,), ambiguous=())
        lines = summary_lines(d, FILES, 400)
        page = plain(without_scripts(diagnosis_page(d, *SUBJECT)))
        assert (f"what to do: {one.remedy}" in lines) == followed
        assert (one.remedy in page) == followed
        assert (LOOK_THERE in lines) == (not followed)
