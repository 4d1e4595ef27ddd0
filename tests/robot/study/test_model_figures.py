"""``bigant model figures``: the quick pictures, the list, and what a person types wrong."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from record.log.recording import Recording
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.study.figure_catalog import CATALOG
from robot.study.figures_errors import draw_error_distributions, draw_planar_force_errors
from robot.study.figures_forces import draw_all_feet, draw_slipping_gait
from robot.study.figures_runtime import draw_parallel, draw_runtime, read_benchmark
from robot.study.figures_walk import draw_walk
from robot.study.walk_comparison import WalkComparison, compare_walk
from robot.study.walk_errors import component_errors, error_table
from robot.virtual.walk import walk_in_memory

QUICK = (
    "line",
    "force-field",
    "friction-error",
    "friction-family",
    "search-flat",
    "search-hexapod",
)
PNG = b"\x89PNG"


def figures(*words: str | Path) -> int:
    return cli.run(["model", "figures", *map(str, words)])


@pytest.mark.soak
def test_the_examples_are_drawn_with_an_index(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    only = [word for name in QUICK for word in ("--only", name)]
    assert figures("--out", tmp_path / "new", *only) == ExitCode.OK
    printed = capsys.readouterr().out
    page = (tmp_path / "new" / "index.html").read_text(encoding="utf-8")
    for name in QUICK:
        assert (tmp_path / "new" / f"{name}.png").read_bytes().startswith(PNG)
        assert f"src='{name}.png'" in page
        assert f"{name}:" in printed
    assert "[6/6]" in printed
    assert "1.98 % across" in page
    assert "20 % along" in page
    assert "bigant model run" in page


def test_the_list_names_every_figure(capsys: pytest.CaptureFixture[str]) -> None:
    assert figures("--list") == ExitCode.OK
    printed = capsys.readouterr().out
    assert len(printed.splitlines()) == len(CATALOG)
    for entry in CATALOG:
        assert entry.name in printed
        assert entry.label in printed
    assert len({entry.name for entry in CATALOG}) == len(CATALOG)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "here", "--only", "fig3"], "'fig3' is no figure; choose from line, "),
        (["--only", "line"], "--out: is needed"),
        (["--out", "here", "--only", "line", "--cycles", "-1"], "--cycles: must be a positive"),
        (["--out", "here", "--only", "tripod", "--tripod", "no.mcap"], "no.mcap cannot be read"),
    ],
)
def test_mistakes_get_one_clear_line(
    words: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert figures(*words) in {ExitCode.USAGE, ExitCode.LOG}
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


def test_a_folder_that_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert figures("--out", tmp_path / "file", "--only", "line") == ExitCode.LOG
    assert "choose another --out" in capsys.readouterr().err


def test_without_benchmark_figures_the_index_says_how_to_make_them(tmp_path: Path) -> None:
    words: list[str | Path] = [
        "--only",
        "runtime",
        "--only",
        "parallel",
        "--benchmark",
        tmp_path / "none.json",
    ]
    assert figures("--out", tmp_path, *words) == ExitCode.OK
    assert not (tmp_path / "runtime.png").exists()
    assert "python -m benchmarks" in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_benchmark_figures_are_drawn(tmp_path: Path) -> None:
    def ribbon(*median: float) -> dict[str, list[float]]:
        shares = {"median": 1.0, "q25": 0.9, "q75": 1.1, "q025": 0.8, "q975": 1.4}
        return {name: [share * value for value in median] for name, share in shares.items()}

    path = tmp_path / "benchmark.json"
    path.write_text(
        json.dumps(
            {
                "legs": [3, 6, 50],
                "ours_us": ribbon(4.0, 5.0, 10.0),
                "mujoco_us": ribbon(20.0, 30.0, 300.0),
                "processes": [1, 2],
                "overhead": {"median": [1.0, 1.2], "q25": [1.0, 1.1], "q75": [1.0, 1.3]},
            }
        )
    )
    benchmark = read_benchmark(path)
    figure, caption = draw_runtime(benchmark)
    assert isinstance(figure, Figure)
    assert "our model x2.5 from 3 to 50 legs" in caption
    assert "MuJoCo x15.0" in caption
    figure, caption = draw_parallel(benchmark)
    assert isinstance(figure, Figure)
    assert "1.20 on 2 processes" in caption


def test_a_broken_benchmark_file_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.json"
    path.write_text('{"legs": [3], "ours_us": {}}')
    words: list[str | Path] = ["--only", "runtime", "--benchmark", path]
    assert figures("--out", tmp_path, *words) == ExitCode.LOG
    assert "broken.json cannot be read" in capsys.readouterr().err


@pytest.fixture(scope="module")
def log() -> Recording:
    shares: list[float] = []
    log = walk_in_memory(load_robot(), "tripod", cycles=0.2, seed=1, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return log


@pytest.fixture(scope="module")
def walk(log: Recording) -> WalkComparison:
    return compare_walk(log)


def test_a_walk_is_compared_under_both_laws(walk: WalkComparison) -> None:
    errors = component_errors(walk)
    assert errors["roll"].support < 1.0  # [mrad]
    assert errors["Fz share"].support < 3.0  # [%]
    assert errors["vy + sway"].coulomb < 0.6 * errors["vy"].coulomb
    for law in (walk.viscous, walk.coulomb):
        true = walk.position_W[-1, :2] - walk.position_W[0, :2]
        np.testing.assert_allclose(law.pose[-1, :2] - law.pose[0, :2], true, atol=3e-3)
        # quasi-static: on each law's own account the feet's horizontal forces balance
        assert np.abs(np.nansum(law.force_xy_B, axis=1)).max() < 1e-3
    assert np.isnan(errors["roll"].viscous)
    assert any("yaw rate" in line for line in error_table(walk))


def test_every_walk_figure_can_be_drawn(walk: WalkComparison) -> None:
    for draw in (
        draw_walk,
        draw_all_feet,
        draw_slipping_gait,
        draw_error_distributions,
        draw_planar_force_errors,
    ):
        figure, caption = draw(walk)
        figure.canvas.draw()
        assert "paper" in caption
        assert "nan" not in caption


def test_a_walk_without_truth_is_drawn_with_what_there_is(log: Recording) -> None:
    nothing = np.full_like
    blind = replace(
        log,
        truth_position_W=nothing(log.truth_position_W, np.nan),
        truth_quaternion_xyzw=nothing(log.truth_quaternion_xyzw, np.nan),
        truth_velocity_B=nothing(log.truth_velocity_B, np.nan),
        truth_foot_velocity_W=nothing(log.truth_foot_velocity_W, np.nan),
        truth_force_n=nothing(log.truth_force_n, np.nan),
    )
    walk = compare_walk(blind)
    assert np.isfinite(walk.force_n).any()  # measured in place of true
    for draw in (draw_walk, draw_slipping_gait, draw_error_distributions):
        figure, _ = draw(walk)
        figure.canvas.draw()


@pytest.mark.thorough
def test_the_walks_are_drawn(tmp_path: Path) -> None:
    assert figures("--out", tmp_path, "--cycles", "0.5") == ExitCode.OK
    drawn = {path.stem for path in tmp_path.glob("*.png")}
    assert drawn >= {entry.name for entry in CATALOG} - {"tables", "runtime", "parallel"}
    table = (tmp_path / "tables.txt").read_text(encoding="utf-8")
    assert "tripod" in table
    assert "metachronal" in table
