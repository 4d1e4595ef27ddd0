"""Plain words: phrases that a reader would have to translate are in no page, message or docstring."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.source_trees import nodes_of
from tests.test_docs import FENCE, PAGES, ROOT, names
from tests.test_names import SOURCES

# What is not written, as a pattern, and what is.
PHRASES = {
    r"kept back": "held-out",
    r"unseen (?:runs?|blocks?|trials?)": "held-out",
    r"simulator and robot part\b|where they part\b": "where they diverge",
    r"foretells?|foretold|lets? expect": "predict, expected",
    r"would tell\b": "the run that settles it",
    r"(?:near-)?equivalents?\b": "indistinguishable",
    r"\brivals?\b(?!:)": "alternative",  # an attribute of that name stays
    r"what healthy (?:runs|robots) (?:lack|show already)|what stands\b": "baseline model errors",
    r"\bfloors? of (?:the )?noise\b|over the floor|of the floor\b(?! plan)": "baseline",
    r"\bcloses \d|closes? \{|of the gap (?:is )?closed": "explains",
    r"a healthy machine would": "the residual of a healthy robot",
    r"taken off\b": "subtracted",
    r"\bnats behind": "held-out log-likelihood difference",
    r"\bbeliev(?:e|es|ed)\b": "use, trust",
    r"\b(?:its|their|the robot's) way\b": "path",
    r"truth where there is": "ground truth, if available",
    r"\bdraws? (?:a|the) log\b": "plot a log",
    r"every way out": "on exit",
    r"feet feel|foot feels": "foot forces",
    r"no chance of a false alarm": "the false-alarm rate cannot be estimated",
    r"\+- is of\b": "+/- covers within-run noise only",
    r"probabilities \S+ off": "calibration error",
    r"\bless (?:what|predicted|the true|true|that of|the filter)": "minus",
    r"\bmend(?:s|ed|ing)?\b": "fix",
    r"wrong on purpose": "deliberately faulty",
    r"see to it that": "ensure",
    r"otherwise than": "different from",
    r"beside it\b": "next to it",
    r"nobody else": "a figure",
    r"\bnews\b": "events, new",
    r"can be asked of": "what a run can show",
    r"in the place of": "instead of",
    r"told (?:apart|from)\b": "distinguished",
    r"cannot (?:be told|tell)\b": "indistinguishable, not determined",
    r"put (?:it |that |this |what \w+ \w+ )?right\b": "correct, fix",
    r"\banew\b": "again",
    r"simulator as it stands\b": "unchanged",
}
PATTERNS = {re.compile(pattern): plain for pattern, plain in PHRASES.items()}  # of small letters


def texts_of(path: Path) -> Iterator[tuple[int, str]]:
    """What a person reads in a file, with its line: pages without code; literals of a module.

    A literal without a space is a name (a key of JSON, a topic, a stage), not words.
    """
    if path.suffix == ".md":
        text = path.read_text(encoding="utf-8")
        yield 1, FENCE.sub(lambda block: "" if block[1] else block[0], text)
        return
    for node in nodes_of(path):
        if isinstance(node, ast.JoinedStr):
            pieces = (str(p.value) if isinstance(p, ast.Constant) else "{}" for p in node.values)
            yield node.lineno, "".join(pieces)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, node.value


def phrases_in(path: Path) -> list[str]:
    """Each phrase that is not plain, with its place and what is written instead."""
    return [
        f"{path.name}:{line}: {hit[0]!r}, but {plain}"
        for line, text in texts_of(path)
        for small in (" ".join(text.lower().split()),)
        for pattern, plain in PATTERNS.items()
        for hit in pattern.finditer(small)
    ]


@pytest.mark.parametrize("path", PAGES, ids=names)
def test_a_page_is_in_plain_words(path: Path) -> None:
    assert not phrases_in(path)


def test_messages_and_docstrings_are_in_plain_words() -> None:
    hits = [
        f"{path.parent.relative_to(ROOT)}/{hit}" for path in SOURCES for hit in phrases_in(path)
    ]
    assert not hits


def test_a_planted_phrase_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Title\n\nRuns kept\nback judge.\n```sh\necho kept back\n```\n", "utf-8")
    assert phrases_in(page) == ["page.md:1: 'kept back', but held-out"]
    module = tmp_path / "module.py"
    module.write_text(
        '"""What the robot believes."""\n\nKEY = "rivals"\nmended = 1\n'
        'LINE = f"it closes {mended} of the gap"\n',
        "utf-8",
    )
    assert phrases_in(module) == [
        "module.py:1: 'believes', but use, trust",
        "module.py:5: 'closes {', but explains",
    ]


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda pattern: pattern.pattern[:30])
def test_plain_words_do_not_match(pattern: re.Pattern[str]) -> None:
    assert not pattern.search(" / ".join(PHRASES.values()))
