"""Plain words: phrases that a reader would have to translate are in no page, message or docstring."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.test_docs import FENCE, PAGES
from tests.test_names import ROOT, SOURCES

# What is not written, as a pattern, and what is.
PHRASES = {
    r"kept back": "held-out",
    r"unseen (?:runs?|blocks?|trials?)": "held-out",
    r"simulator and robot part\b|where they part\b": "where they diverge",
    r"foretells?|foretold|lets? expect": "predict, expected",
    r"would tell\b": "the run that settles it",
    r"(?:near-)?equivalents?\b": "indistinguishable",
    r"\brivals?\b": "alternative",
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
}
PATTERNS = {re.compile(pattern, re.IGNORECASE): plain for pattern, plain in PHRASES.items()}
# Justified: (end of the file's name, text of the hit).
ALLOWED: frozenset[tuple[str, str]] = frozenset()


def texts_of(path: Path) -> Iterator[tuple[int, str]]:
    """What a person reads in a file: pages without their code, and literals and docstrings of a module."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield 1, FENCE.sub(lambda m: m[0] if not m[1] else "\n" * m[0].count("\n"), text)
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            pieces = [str(p.value) if isinstance(p, ast.Constant) else "{}" for p in node.values]
            yield node.lineno, "".join(pieces)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def phrases_in(path: Path) -> Iterator[str]:
    """Each phrase that is not plain, with its place and what is written instead."""
    for line, text in texts_of(path):
        for pattern, plain in PATTERNS.items():
            for hit in pattern.finditer(re.sub(r"\s+", " ", text)):
                if not any(path.as_posix().endswith(e) and hit[0] == t for e, t in ALLOWED):
                    yield f"{path.relative_to(path.anchor)}:{line}: {hit[0]!r} -> {plain}"


def read_by_people() -> list[Path]:
    return [*PAGES, *SOURCES]


@pytest.mark.parametrize("path", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_a_page_is_in_plain_words(path: Path) -> None:
    assert not list(phrases_in(path))
