"""``bigant campaign score --realities`` on answers that are there; a cluster; bad input."""

import gc
import json
import math
import sys
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from gap.detectable import Detectable
from gap.interfaces import Cause
from robot.campaign import check, make
from robot.campaign.answers import ANSWERS, ANSWERS_ALONE, STANDING
from robot.campaign.case import read_answer
from robot.campaign.executor import campaign_executor
from robot.cli.main import run as command
from robot.console.exit_codes import ExitCode
from robot.gap_report.causes_file import write_causes
from tests.robot.scenarios import ONE, write_scenario

STAGES = {"foot_friction": "friction", "servo_lag": "actuation"}


def written(folder: Path, cases: dict[str, tuple[str, str, str]]) -> None:
    """A campaign whose cases (kind, true effect, named effect) are answered already."""
    labels: dict[str, Any] = {}
    for name, (kind, true, named) in cases.items():
        trial = folder / "cases" / name / "trial_1.parquet"
        trial.parent.mkdir(parents=True, exist_ok=True)
        trial.touch()
        effects = (
            [{"name": true, "stage": STAGES[true], "leg": "", "parameters": {}}] if true else []
        )
        labels[name] = {"kind": kind, "robot": 0, "seeds": [1], "effects": effects}
        causes = (
            [{"effect": named, "legs": [], "parameters": {}, "probability": 0.9}] if named else []
        )
        answer = {
            "verdict": "explained" if named else "no_gap",
            "where": {"stage": STAGES.get(named, "")},
            "causes": causes,
            "gap": {"shrink": None},
            "none_of_these": 0.1,
            "floor": {"source": "references"},
            "fit": {"closed": 0.9, "excess_after": 1.2, "worst_after": 2.0, "p_after": 0.2},
            "seconds": 1.0,
        }
        path = folder / "answers" / f"{name}.json"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(answer))
    (folder / "labels.json").write_text(json.dumps({"entropy": "", "cases": labels}))


@pytest.fixture
def realities(tmp_path: Path) -> Path:
    control, lag = ("control", "", ""), ("single", "servo_lag", "servo_lag")
    written(tmp_path / "calm", {"a": lag, "b": lag, "c": control})
    wrong = ("single", "servo_lag", "foot_friction")
    written(tmp_path / "rough", {"a": lag, "b": wrong, "c": ("control", "", "servo_lag")})
    return tmp_path


def test_each_has_a_row_and_the_worst_is_named(
    realities: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, page = realities / "figures.json", realities / "figures.md"
    line = [
        "gap",
        "check",
        str(realities),
        "--realities",
        "--json",
        str(out),
        "--markdown",
        str(page),
    ]
    assert command(line) == ExitCode.VERDICT_FAILED
    told = capsys.readouterr().out.splitlines()
    rows = {one.split()[0]: one.split() for one in told[1:4]}
    assert "100.0%" in rows["calm"]
    assert "50.0%" in rows["rough"]
    assert rows["all"][:5] == ["all", "6", "75.0%", "of", "4"]
    assert any(one.startswith("worst: rough, which misses") for one in told)
    assert "rough b  servo_lag: foot_friction" in " ".join(told)
    whole = json.loads(out.read_text())
    assert whole["worst"] == "rough"
    first = {one["name"]: one["figures"][0]["value"] for one in whole["realities"]}
    assert first == {"calm": 1.0, "rough": 0.5}
    assert {one["name"] for one in whole["left_out"]["causes"]} == {"calm", "rough"}
    assert "| rough | 3 | 50.0% of 2 * |" in page.read_text()


def test_a_folder_that_holds_none_and_options_that_do_not_go_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["campaign", "score", str(tmp_path), "--realities"]) != 0
    assert "holds no campaigns" in capsys.readouterr().err
    scenario = write_scenario(tmp_path, ONE)
    line = ["campaign", "score", str(tmp_path), "--realities", "--scenario", str(scenario)]
    assert command(line) == ExitCode.USAGE
    assert "is for one campaign" in capsys.readouterr().err


def test_a_case_without_an_answer_is_counted_and_does_not_stop_the_others(
    realities: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(check, "campaign_executor", lambda *_: ThreadPoolExecutor(1))
    (realities / "calm" / "answers" / "a.json").unlink()  # its trial is an empty file
    out = realities / "figures.json"
    line = ["campaign", "score", str(realities), "--realities", "--jobs", "1", "--json", str(out)]
    assert command(line) == ExitCode.VERDICT_FAILED
    assert "calm a got no answer" in capsys.readouterr().out
    whole = json.loads(out.read_text())
    assert list(whole["crashed"]["calm"]) == ["a"]
    calm = next(one for one in whole["realities"] if one["name"] == "calm")
    assert calm["crashed"] == ["a"]
    assert calm["figures"][-1] == {
        "name": "crashed", "value": 1.0, "low": None, "high": None, "cases": 3, "bar": "0", "met": False,
        "by_chance": None, "p": None,
    }  # fmt: skip


def test_a_cluster_without_dask_is_one_sentence(
    realities: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    line = ["campaign", "score", str(realities), "--realities", "--dask", "tcp://127.0.0.1:9"]
    assert command(line) == ExitCode.USAGE
    told = capsys.readouterr().err
    assert "--dask: needs Dask; install it with" in told
    assert len(told.strip().splitlines()) == 1


@pytest.mark.thorough
def test_a_cluster_gives_the_same_answers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Campaign and check through ``distributed``'s executor, and in a thread here."""
    distributed = pytest.importorskip("distributed", reason="pip install -e '.[dask]'")
    text = ONE.replace("seconds = 0.1", "seconds = 12.0").replace("count = 1", "count = 0")
    text = text.replace("controls = 1", "controls = 0")

    def thread(jobs: int, dask: str | None) -> AbstractContextManager[Executor]:
        return ThreadPoolExecutor(jobs) if dask is None else campaign_executor(jobs, dask)

    monkeypatch.setattr(make, "campaign_executor", thread)
    monkeypatch.setattr(check, "campaign_executor", thread)
    scenario = write_scenario(tmp_path, text)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        where = {"here": ["--jobs", "1"], "there": ["--dask", cluster.scheduler_address]}
        answers = {}
        for name, options in where.items():
            out = tmp_path / name
            made = ["campaign", "make", str(scenario), "--out", str(out), "--reality", "cascaded"]
            assert command([*made, *options]) == 0
            figures = tmp_path / f"{name}.json"
            command(
                ["campaign", "score", str(out), "--realities", "--json", str(figures), *options]
            )
            capsys.readouterr()
            whole = json.loads(figures.read_text())
            for case in whole["cases"]["cascaded"]:
                case["answer"]["seconds"] = None
            trials = [p.read_bytes() for p in sorted(out.rglob("*.parquet"))]
            assert len(trials) == 1
            answers[name] = whole["cases"], whole["crashed"], trials
    gc.collect()  # the cluster's finalizers speak here, not in the middle of another test
    assert answers["here"] == answers["there"]


def test_answers_without_references_are_kept_apart_and_counted_for_what_they_can_say(
    realities: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("calm", "rough"):
        folder = realities / name
        (folder / ANSWERS).rename(folder / ANSWERS_ALONE)
        write_causes((Cause("servo_lag", (), (0.05,)),), folder / ANSWERS_ALONE / STANDING)
    line = ["campaign", "score", str(realities), "--realities", "--no-references"]
    assert command([*line, "--json", str(realities / "figures.json")]) == ExitCode.VERDICT_FAILED
    head, calm, rough, together, *_ = capsys.readouterr().out.splitlines()
    assert "true cause among the named" in head
    assert "healthy: nothing but the baseline" in head
    assert calm.split()[:5] == ["calm", "3", "100.0%", "of", "2"]
    assert rough.split()[:5] == ["rough", "3", "50.0%", "of", "2"]
    assert together.split()[5:8] == ["*", "100.0%", "of"], "a lag is what this robot always has"


def test_a_size_that_no_run_can_show_is_read_as_infinite(realities: Path) -> None:
    path = realities / "calm" / "answers" / "a.json"
    one = {"effect": "servo_lag", "parameter": "time_constant_s", "size": None, "unit": "s", "neutral": 0.0,
           "lower": 0.0, "upper": 0.5}  # fmt: skip
    # as a diagnosis writes it: beside the size what follows from it
    written: list[dict[str, object]] = [{**one, "values": []}]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"detectable": written}))
    assert read_answer(path).detectable == (
        Detectable("servo_lag", "time_constant_s", math.inf, "s", 0.0, 0.0, 0.5),
    )
