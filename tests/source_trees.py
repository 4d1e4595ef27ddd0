"""Syntax trees of our modules, each parsed once in a process: six tests walk through all of them."""

import ast
from functools import cache
from pathlib import Path


@cache
def tree_of(path: Path) -> ast.Module:
    """Return the tree of a file that does not change while the tests run; nobody changes the tree."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """Return all nodes of the tree, as ``ast.walk`` gives them."""
    return tuple(ast.walk(tree_of(path)))
