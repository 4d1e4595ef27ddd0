"""Run the cells of examples/notebook.ipynb and keep what they give: ``python docs/write_notebook.py``.

The notebook itself is the source: change its cells in any editor of notebooks. No kernel and no Jupyter is
needed; a cell's last expression is shown as a notebook shows it.
"""

import ast
import base64
import contextlib
import io
import json
from pathlib import Path
from typing import Any

NOTEBOOK = Path(__file__).resolve().parent.parent / "examples" / "notebook.ipynb"
DPI = 60


def run_cell(source: str, names: dict[str, Any]) -> tuple[str, object]:
    """Run a cell with the names so far; return what it prints, and its last expression's value."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        value = (
            None
            if last is None
            else eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        )
    return printed.getvalue(), value


def outputs_of(printed: str, value: object, number: int) -> list[dict[str, Any]]:
    """Return the outputs of a cell as a notebook file keeps them."""
    outputs: list[dict[str, Any]] = []
    if printed:
        outputs.append({"output_type": "stream", "name": "stdout", "text": _lines(printed)})
    if value is not None:
        data: dict[str, Any] = {"text/plain": _lines(repr(value))}
        if figures := getattr(value, "figures", None):
            buffer = io.BytesIO()
            next(iter(figures.values())).savefig(buffer, format="png", dpi=DPI)
            data["image/png"] = base64.b64encode(buffer.getvalue()).decode("ascii")
        outputs.append({
            "output_type": "execute_result", "execution_count": number, "metadata": {}, "data": data,
        })  # fmt: skip
    return outputs


def _lines(text: str) -> list[str]:
    return text.rstrip("\n").splitlines(keepends=True)


def main() -> None:
    """Run all cells in order and write the file."""
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    names: dict[str, Any] = {"__name__": "__main__"}
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(code, start=1):
        printed, value = run_cell("".join(cell["source"]), names)
        cell["execution_count"], cell["outputs"] = number, outputs_of(printed, value, number)
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
