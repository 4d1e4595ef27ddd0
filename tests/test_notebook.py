"""The notebook among the examples: its cells run in order, in plain Python, and give what it keeps."""

import json
import re
import runpy
from pathlib import Path
from typing import Any

import pytest

from tests.test_layers import ROOT

NOTEBOOK = ROOT / "examples" / "notebook.ipynb"
CELLS = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
CODE = [cell for cell in CELLS if cell["cell_type"] == "code"]
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def text_of(outputs: list[dict[str, Any]]) -> str:
    parts = [one["text"] if "text" in one else one["data"]["text/plain"] for one in outputs]
    return "\n".join("".join(lines) for lines in parts)


def test_every_cell_was_run_and_pictures_are_in_the_file() -> None:
    assert [cell["execution_count"] for cell in CODE] == list(range(1, len(CODE) + 1))
    assert sum("image/png" in str(cell["outputs"]) for cell in CODE) >= 4
    assert NOTEBOOK.stat().st_size < 400_000


def test_it_uses_the_door_only() -> None:
    for cell in CODE:
        for line in cell["source"]:
            imported = re.match(r"\s*(?:from|import) (\w+)", line)
            assert not imported or imported[1] in {"bigant", "numpy", "pathlib", "tempfile"}, line


@pytest.mark.soak
@pytest.mark.long
@pytest.mark.usefixtures("usual_pace")  # as the numbers that are kept
def test_the_cells_run_in_order_and_give_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tools = runpy.run_path(str(ROOT / "docs" / "write_notebook.py"))
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(CODE, start=1):
        printed, value = tools["run_cell"]("".join(cell["source"]), names)
        now, kept = text_of(tools["outputs_of"](printed, value, number)), text_of(cell["outputs"])
        # numbers may differ in their last places from computer to computer, words may not
        assert NUMBER.sub("#", now).split() == NUMBER.sub("#", kept).split(), cell["source"]
    assert names["report"].verdict == "explained"
    assert list(names["report"].parameters) == ["leg_stiffness MR"]
