"""The documents: links lead somewhere, commands parse, Python compiles, the reference is current."""

import re
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SKIPPED = {".venv", "site", "runs", ".git", ".pytest_cache"}
PAGES = sorted(
    path for path in ROOT.rglob("*.md") if not SKIPPED & set(path.relative_to(ROOT).parts)
)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def blocks(path: Path, language: str) -> list[str]:
    """Contents of the fenced blocks of a language."""
    text = path.read_text(encoding="utf-8")
    return [body for name, body in FENCE.findall(text) if name == language]


def anchors_of(path: Path) -> set[str]:
    """The anchors that GitHub gives a page's headings."""
    text = FENCE.sub("", path.read_text(encoding="utf-8"))
    seen: Counter[str] = Counter()
    anchors = set()
    for heading in re.findall(r"^#+ +(.+?) *$", text, re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
        anchors.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
        seen[slug] += 1
    return anchors


def links_of(path: Path) -> list[str]:
    """Relative links of a page."""
    text = re.sub(r"`[^`\n]*`", "", FENCE.sub("", path.read_text(encoding="utf-8")))
    return [link for link in LINK.findall(text) if not re.match(r"\w+:", link)]


def names(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("path", PAGES, ids=names)
def test_every_link_leads_somewhere(path: Path) -> None:
    for link in links_of(path):
        file, _, anchor = link.partition("#")
        target = (path.parent / file).resolve() if file else path
        assert target.exists(), f"{link} in {path.name}"
        if anchor and target.suffix == ".md":
            assert anchor in anchors_of(target), f"{link} in {path.name}"


def test_anchors_are_those_of_github(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# Your robot's file\n\n## A `b` (c)\n## A b c\n```sh\n# no heading\n```\n", "utf-8"
    )
    assert anchors_of(page) == {"your-robots-file", "a-b-c", "a-b-c-1"}


def command_lines(path: Path) -> list[list[str]]:
    """Every call of bigant in the shell blocks of a page, as words."""
    calls = []
    for block in blocks(path, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            starts = [i for i, w in enumerate(words) if Path(w).name == "bigant"]
            for start in starts[:1]:
                if start and words[start - 1].startswith("-"):
                    continue
                ends = [
                    i for i, w in enumerate(words) if i > start and w in {">", "|", "||", "&&", ";"}
                ]
                calls.append(words[start + 1 : ends[0] if ends else None])
    return calls


@pytest.mark.parametrize("path", [p for p in PAGES if command_lines(p)], ids=names)
def test_every_command_in_a_page_parses(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from robot.cli import full_parser

    parser = full_parser()
    for words in command_lines(path):
        # [--json] and LOG... are how a page writes what may be left out and repeated
        plain = [w.strip("[]").removesuffix("...") for w in words]
        try:
            parser.parse_args(plain)
        except SystemExit:
            pytest.fail(f"bigant {shlex.join(words)}: {capsys.readouterr().err}")


def test_commands_are_found_in_pages() -> None:
    assert len(command_lines(ROOT / "docs" / "tutorial.md")) > 20
    assert ["drive", "--teleop"] in command_lines(ROOT / "README.md")


@pytest.mark.parametrize("path", [p for p in PAGES if blocks(p, "python")], ids=names)
def test_python_in_a_page_compiles_and_its_imports_exist(path: Path) -> None:
    for block in blocks(path, "python"):
        compile(block, names(path), "exec")
        imports = [
            line for line in block.splitlines() if re.match(r"(from [\w.]+ import|import) ", line)
        ]
        done = subprocess.run(
            [sys.executable, "-c", "\n".join(imports)], cwd=ROOT, capture_output=True, text=True,
            check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{path.name}: {done.stderr}"


def test_the_tutorials_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from robot import cli

    monkeypatch.chdir(tmp_path)
    words = ["drive", "--virtual-time", "--duration", "0.2", "--frequency-hz", "0.2"]
    assert cli.run([*words, "--log", "runs/first.mcap"]) == 0
    found = blocks(ROOT / "docs" / "tutorial.md", "python")
    assert found
    for block in found:
        exec(compile(block, "tutorial.md", "exec"), {})


def test_pages_of_modules_are_made_from_their_docstrings(tmp_path: Path) -> None:
    pdoc = pytest.importorskip("pdoc")
    pdoc.render.configure(docformat="google", show_source=False)
    pdoc.pdoc("model.linkage", "record.reader", output_directory=tmp_path)
    page = (tmp_path / "model" / "linkage.html").read_text(encoding="utf-8")
    assert "linkage_pose" in page
    assert "Shaft angles, any shape" in page


def test_the_command_reference_is_current() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import runpy; print(runpy.run_path("
         "'docs/write_cli_reference.py')['page'](), end='')"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    current = (ROOT / "docs" / "reference" / "cli.md").read_text(encoding="utf-8")
    assert done.stdout == current, "run: make docs"


def test_readme_shows_what_is_printed() -> None:
    """Numbers aside; make docs-assets runs the commands again and keeps what they print."""
    ran = subprocess.run(
        [sys.executable, "docs/write_outputs.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout
