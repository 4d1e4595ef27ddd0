"""The documents: links lead somewhere, commands parse, Python compiles, the reference is current."""

import importlib
import pkgutil
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
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
    from robot.cli.main import full_parser

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


def test_every_block_is_of_a_kind_that_is_tested() -> None:
    """sh, toml and python below; without a name it is what a command prints, mermaid is a drawing."""
    found = {name for path in PAGES for name, _ in FENCE.findall(path.read_text(encoding="utf-8"))}
    assert found <= {"sh", "toml", "python", "", "mermaid"}


@pytest.mark.parametrize("path", [p for p in PAGES if blocks(p, "sh")], ids=names)
def test_a_shell_can_read_every_block_and_what_it_names_exists(path: Path) -> None:
    script = "\n".join(blocks(path, "sh"))
    read = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True, check=False)
    assert read.returncode == 0, read.stderr
    made = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for target in re.findall(r"^make ([a-z-]+)", script, re.MULTILINE):
        assert target in made, f"make {target} in {path.name}"
    for file in re.findall(r"\bpython ((?:examples|docs)/\S+\.py)", script):
        assert (ROOT / file).is_file(), f"{file} in {path.name}"


@pytest.mark.parametrize("path", [p for p in PAGES if blocks(p, "toml")], ids=names)
def test_every_piece_of_a_file_is_toml(path: Path) -> None:
    for block in blocks(path, "toml"):
        assert tomllib.loads(block)


# The cells of the notebook's page are run by tests/test_notebook.py.
@pytest.mark.parametrize(
    "path", [p for p in PAGES if blocks(p, "python") and p.name != "notebook.md"], ids=names
)
def test_python_in_a_page_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    from model.systems.disk import WEIGHT_N, disk_contact, random_disk_poses

    monkeypatch.chdir(tmp_path)
    if path.name == "tutorial.md":
        (tmp_path / "runs").mkdir()
        shutil.copyfile(request.getfixturevalue("short_walk"), tmp_path / "runs" / "first.mcap")
    # what the pages say in words: feet, their springs and a weight of the reader's own
    given = {
        "feet": random_disk_poses(10, 6, np.random.default_rng(0)),
        "contact": disk_contact(6),
        "weight_n": WEIGHT_N,
    }
    for block in blocks(path, "python"):
        exec(compile(block, names(path), "exec"), dict(given))


def test_pages_of_modules_are_made_from_their_docstrings(tmp_path: Path) -> None:
    pdoc = pytest.importorskip("pdoc")
    pdoc.render.configure(docformat="google", show_source=False)
    pdoc.pdoc("model.kinematics.four_bar", "record.log.reader", output_directory=tmp_path)
    page = (tmp_path / "model" / "kinematics" / "four_bar.html").read_text(encoding="utf-8")
    assert "linkage_pose" in page
    assert "Shaft angles, any shape" in page


def test_every_module_can_be_imported_for_its_page() -> None:
    """`make docs` ends at the first that cannot; those that need a large extra are left out there."""
    pytest.importorskip("pdoc")
    site = runpy.run_path(str(ROOT / "docs" / "write_site.py"))
    left_out = site["LEFT_OUT"]
    for folder in site["FOLDERS"]:
        for module in pkgutil.walk_packages([str(ROOT / folder)], f"{folder}."):
            if module.name not in left_out and not module.name.endswith("__main__"):
                importlib.import_module(module.name)


@pytest.mark.parametrize("kind", ["cli", "modules"])
def test_a_written_reference_is_current(kind: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import runpy; print(runpy.run_path("
         f"'docs/write_{kind}_reference.py')['page'](), end='')"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    current = (ROOT / "docs" / "reference" / f"{kind}.md").read_text(encoding="utf-8")
    assert done.stdout == current, "run: make docs"


def test_the_page_of_constants_is_current() -> None:
    write = runpy.run_path(str(ROOT / "docs" / "write_gap_constants.py"))
    current = (ROOT / "docs" / "gap_constants.md").read_text(encoding="utf-8")
    assert write["page"]() == current, "run: make docs"


def test_every_module_says_its_idea_in_one_line() -> None:
    page = (ROOT / "docs" / "reference" / "modules.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert len(rows) > 300
    for row in rows:
        assert re.search(r"[.?`] \|$", row), row


def test_the_page_of_the_model_says_what_was_measured() -> None:
    """make docs-assets measures again; here the page is compared with the figures that are kept."""
    ran = subprocess.run(
        [sys.executable, "docs/write_model_page.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr


def test_readme_and_tutorial_show_what_is_printed() -> None:
    """Numbers aside; make docs-assets runs the commands again and keeps what they print."""
    ran = subprocess.run(
        [sys.executable, "docs/write_outputs.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout
