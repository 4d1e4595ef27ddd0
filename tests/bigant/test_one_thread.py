"""One thread of linear algebra a process, unless the environment says otherwise."""

import os
import subprocess
import sys

import pytest

from bigant.one_thread import VARIABLE, one_thread
from tests.test_layers import ROOT


def test_it_is_asked_for_unless_somebody_else_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    one_thread()
    assert os.environ[VARIABLE] == "1"
    monkeypatch.setenv(VARIABLE, "3")
    one_thread()
    assert os.environ[VARIABLE] == "3"


def test_the_command_asks_before_numpy_is_there() -> None:
    code = f"""
import os, sys
from importlib.abc import MetaPathFinder
class Watch(MetaPathFinder):
    def find_spec(self, name, *_):
        if name == "numpy":
            print(os.environ.get({VARIABLE!r}))
            raise SystemExit
sys.meta_path.insert(0, Watch())
sys.argv = ["bigant", "model", "run", "bigant"]
from bigant.__main__ import main
main()
"""
    without = {name: value for name, value in os.environ.items() if name != VARIABLE}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=without, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert done.stdout == "1\n", done.stderr


def test_the_tests_run_so() -> None:
    assert os.environ[VARIABLE] == "1"
