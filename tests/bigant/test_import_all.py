"""What ``make install`` imports: every module of ours, whatever extras are there."""

import importlib
from collections.abc import Callable
from types import ModuleType

import pytest

from bigant import import_all as module
from tests.test_layers import OURS

KEPT = importlib.import_module


def lacking(missing: str) -> Callable[[str], ModuleType]:
    """An import that does not find one module, wherever it is asked for."""

    def load(name: str) -> ModuleType:
        if name == "robot.view.film_file":
            raise ModuleNotFoundError(name=missing)
        return KEPT(name)

    return load


def test_it_knows_all_folders() -> None:
    assert set(module.FOLDERS) == set(OURS)


def test_an_extra_may_be_missing_and_a_module_of_ours_may_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(importlib, "import_module", lacking("imageio_ffmpeg"))
    module.import_all()
    monkeypatch.setattr(importlib, "import_module", lacking("robot.view.frames"))
    with pytest.raises(ModuleNotFoundError):
        module.import_all()
