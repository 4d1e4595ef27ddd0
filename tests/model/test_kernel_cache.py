"""Compiled kernels on disk: found by every clone with the same sources, and never for other ones."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from model import compiled, kernel_cache
from model.kernel_cache import KEPT_S, KernelFiles, kernel_folder

ROOT = Path(__file__).parents[2]
KEY = (("float64", "int64"), ("x86_64", "processor", "+avx2"), ("a", "b"))


def kept(folder: Path, stamp: str = "stamp", version: str = "0.61") -> KernelFiles:
    return KernelFiles("model.motion.turn", stamp, version, str(folder))


def test_a_kernel_is_found_by_its_sources_compiler_types_and_processor(tmp_path: Path) -> None:
    kept(tmp_path / "new").save(KEY, b"code")
    assert kept(tmp_path / "new").load(KEY) == b"code"
    assert kept(tmp_path / "new", stamp="other").load(KEY) is None
    assert kept(tmp_path / "new", version="0.62").load(KEY) is None
    assert kept(tmp_path / "new").load((KEY[0], ("x86_64", "older", ""), KEY[2])) is None
    assert kept(tmp_path).load(KEY) is None


def test_two_sets_of_types_never_share_a_file(tmp_path: Path) -> None:
    one, other = kept(tmp_path), kept(tmp_path)
    second = (("float32",), *KEY[1:])
    one.save(KEY, b"one")
    other.save(
        second, b"other"
    )  # numba's own index, read before the first was written, mixes them up
    assert (one.load(KEY), one.load(second)) == (b"one", b"other")
    assert len(list(tmp_path.iterdir())) == 2


def test_a_damaged_or_foreign_file_is_no_kernel(tmp_path: Path) -> None:
    files = kept(tmp_path)
    files.save(KEY, b"code" * 100)
    path = Path(files.path(KEY))
    whole = path.read_bytes()
    path.write_bytes(whole[:-7])
    assert files.load(KEY) is None
    path.write_bytes(b"")
    assert files.load(KEY) is None
    path.write_bytes(whole)
    assert files.load(KEY) == b"code" * 100
    path.rename(files.path(("another key",)))
    assert files.load(("another key",)) is None


def test_what_cannot_be_written_leaves_nothing_and_stops_nobody(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way", encoding="utf-8")
    files = kept(blocked / "folder")
    files.save(KEY, b"code")
    assert files.load(KEY) is None


def test_kernels_that_nobody_starts_any_more_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_cache, "_tidied", set())
    ages = {"old.kernel": KEPT_S + 10, "used.kernel": KEPT_S - 1000, "unfinished-x": 2 * KEPT_S}
    kept(tmp_path).save(("first",), b"")
    now_s = os.stat(kept(tmp_path).path(("first",))).st_mtime
    for name, age_s in {**ages, "somebody's.txt": 2 * KEPT_S}.items():
        (tmp_path / name).write_bytes(b"")
        os.utime(tmp_path / name, (now_s - age_s, now_s - age_s))
    monkeypatch.setattr(kernel_cache, "_tidied", set())
    kept(tmp_path).save(KEY, b"code")
    left = {path.name for path in tmp_path.iterdir() if not path.name.startswith("model.")}
    assert left == {"used.kernel", "somebody's.txt"}


def test_the_folder_is_the_users_or_the_one_that_was_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/somewhere/else")
    assert kernel_folder() == "/somewhere/else"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere/cache")
    if sys.platform == "linux":
        assert kernel_folder() == "/somewhere/cache/bigant/kernels"


@pytest.mark.skipif(not compiled.compiles(), reason="numba is not installed")
def test_machine_code_does_not_outlive_any_source_that_it_is_made_of() -> None:
    from model.traction.coulomb_frame import balance_frame

    kernel: Any = balance_frame
    files = kernel.dispatcher()._cache._cache_file
    stamp = compiled._stamp("model.traction.coulomb_frame")
    assert len(stamp) == 64
    assert files._made_from.startswith(stamp)


SECOND_CLONE = """
import sys
from numba.core import event

class Count(event.Listener):
    compiled = 0
    def on_start(self, event):
        Count.compiled += 1
    def on_end(self, event):
        pass

event.register("numba:compile", Count())
import numpy as np
from model.motion.differentiate import latest_rate
latest_rate(np.arange(3), np.zeros((3, 1)))
print(Count.compiled)
"""


@pytest.mark.soak
@pytest.mark.skipif(not compiled.compiles(), reason="numba is not installed")
def test_a_second_clone_compiles_nothing(tmp_path: Path) -> None:
    def compiled_in(clone: Path) -> int:
        made = subprocess.run(
            [sys.executable, "-c", SECOND_CLONE],
            cwd=clone,
            env={"XDG_CACHE_HOME": str(tmp_path / "cache"), "HOME": str(tmp_path), "PATH": "",
                 "PYTHONPATH": str(clone)},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return int(made.stdout)

    from shutil import copytree, ignore_patterns

    second = tmp_path / "clone"
    copytree(ROOT / "model", second / "model", ignore=ignore_patterns("__pycache__"))
    assert compiled_in(ROOT) > 0
    assert compiled_in(second) == 0
    source = second / "model" / "motion" / "differentiate.py"
    source.write_text(source.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    assert compiled_in(second) > 0
