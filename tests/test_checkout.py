"""What is in the repository belongs there."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {
    ".ci", "benchmarks", "bigant", "config", "docs", "drivers", "examples", "gaits", "gap", "model",
    "record", "robot", "sim_hw", "tests",
}  # fmt: skip
FILES = {
    ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "Makefile",
    "README.md", "constraints.txt", "pyproject.toml",
}  # fmt: skip
LINK = "120000"  # git's mode of a symbolic link


def test_nothing_stray_is_committed() -> None:
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("no checkout of git to look at")
    listed = subprocess.run(
        ["git", "ls-files", "-s"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    rows = [line.split(maxsplit=3) for line in listed.splitlines()]
    assert not [path for mode, *_, path in rows if mode == LINK]
    top = {path.split("/")[0] for *_, path in rows if "/" in path}
    assert top <= FOLDERS, "a new top-level folder is a decision: add it here"
    assert {path for *_, path in rows if "/" not in path} <= FILES
