"""A wheel of the project outside a clone: robot file, examples and pages are in it, and the commands work.

It is installed without its dependencies, which are those of this environment.
"""

import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

from tests.test_layers import OURS, ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built by the build backend itself, as pip and uv have it built."""
    folder = tmp_path_factory.mktemp("wheel")
    words = ["-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, check=True)
    (made,) = folder.glob("bigant-*.whl")
    return made


@pytest.fixture(scope="module")
def site(wheel: Path) -> Path:
    """Where it is installed: a folder of its own, that no clone is beside."""
    folder = wheel.parent / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def lab(wheel: Path) -> Path:
    """A lab's folder, with modules of its own that have our names."""
    folder = wheel.parent / "lab"
    folder.mkdir()
    for name in ("model", "robot"):
        (folder / f"{name}.py").write_text(
            "raise SystemExit('their code has run')\n", encoding="utf-8"
        )
    return folder


def bigant(site: Path, lab: Path, *words: str, verdict: bool = False) -> str:
    """Run the installed command as a stranger does and return what it prints; its verdict may be bad."""
    others = sysconfig.get_paths()["purelib"]
    # -S leaves out the site's path files, and with them the clone of this very project
    code = f"import sys; sys.path[0:1] = [{str(site)!r}, {others!r}]; sys.argv[0] = 'bigant'\n"
    code += "from bigant.__main__ import main; main()"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code, *words], cwd=lab, capture_output=True, text=True,
        check=False, env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
    )  # fmt: skip
    assert done.returncode == 0 or (verdict and done.returncode == 1), (
        f"{words}: {done.stdout}{done.stderr}"
    )
    return done.stdout


def test_everything_that_comes_with_the_program_is_in_the_wheel_once(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        for name in ("config/bigant.toml", "examples/octopod.toml", "docs/log.md"):
            assert archive.read(f"robot/shipped/{name}") == (ROOT / name).read_bytes()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == set(OURS)
    assert len(names) == len(set(names))
    assert {f"{name}/py.typed" for name in OURS} <= set(names)
    assert "record/maps/sliding_cube/map.toml" in names
    for part in ("report.html", "moving.css", "moving.js", "replay.js", "switches.js"):
        assert f"robot/report/templates/{part}" in names
    assert not [name for name in names if "__pycache__" in name or name.startswith("tests/")]


@pytest.mark.soak
@pytest.mark.long
def test_drive_show_import_and_diagnose_work_in_an_empty_folder(site: Path, lab: Path) -> None:
    short = ["--cycles", "0.2", "--frequency-hz", "0.3"]
    bigant(site, lab, "drive", "--virtual-time", *short, "--log", "walk.mcap")
    assert "tripod" in bigant(site, lab, "show", "walk.mcap")
    assert (lab / "walk.html").is_file()
    assert "estimator" in bigant(site, lab, "odom", "walk.mcap", "--compare")
    for seed in ("0", "1"):
        words = ["--seconds", "4", "--fast", "--seed", seed, "--out", f"run{seed}.parquet"]
        assert "4 s walked" in bigant(site, lab, "sim", "run", *words)
    assert "kept" in bigant(site, lab, "import", "run0.parquet", "--out", "imported.mcap")
    runs = ["run0.parquet", "--reference", "run1.parquet"]
    printed = bigant(site, lab, "gap", "diagnose", *runs, "--jobs", "2", verdict=True)
    verdicts = {"NO GAP", "EXPLAINED", "AMBIGUOUS", "UNEXPLAINED"}
    assert len(verdicts & set(printed.splitlines())) == 1


@pytest.mark.soak
def test_an_example_runs_where_it_is_copied_to(site: Path, lab: Path) -> None:
    listed = bigant(site, lab, "examples")
    assert "examples/octopod.toml" in listed
    bigant(site, lab, "examples", "--out", "copied")
    assert (lab / "copied" / "config" / "bigant.toml").is_file()
    words = ["--robot", "copied/examples/octopod.toml", "--cycles", "0.1", "--frequency-hz", "0.3"]
    bigant(site, lab, "drive", "--virtual-time", *words, "--log", "octopod.mcap")


@pytest.mark.soak
def test_an_error_names_a_page_that_can_be_opened(site: Path, lab: Path) -> None:
    with pytest.raises(AssertionError) as failed:
        bigant(site, lab, "show", "absent.mcap")
    page = str(failed.value).split("(see ")[1].split(")")[0]
    assert Path(page).is_file()
    assert Path(page).is_relative_to(site)
