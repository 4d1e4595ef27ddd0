"""``bigant examples``: robot files and scripts that come with the program, listed or copied."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from model.errors import ConfigError
from record.whole_file import whole_file, writing
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.screen_fit import columns_of
from robot.console.shipped import HOME, shipped
from robot.console.table import row_lines
from robot.requests.single import ExamplesRequest

FOLDERS = ("config", "examples")
# The first words of a file: behind a comment's sign, in a docstring, or in a notebook's first cell.
FIRST_WORDS = re.compile(r'^(?:# |"""|<!-- *|\s*"# )([^"\n\\]+)', re.MULTILINE)
HEAD = 4000  # letters in which they are looked for


def copy_examples(request: ExamplesRequest) -> ExitCode:
    """List the files, or copy them.

    Raises:
        ConfigError: There is no such file.
        RecordError: A copy cannot be written.
    """
    names = [name for name in _names() if not request.names or _is_one(name, request.names)]
    for word in request.names:
        if not any(_is_one(name, (word,)) for name in names):
            raise ConfigError("NAME", f"there is no {word!r}; bigant examples lists what there is")
    if request.out is None:
        words = {name: first_words(shipped(name)) for name in names}
        files = [{"name": n, "what": what, "file": shipped(n)} for n, what in words.items()]
        rows = [*words.items(), ("folder", str(HOME)), ("pages", str(shipped("docs")))]
        lines = row_lines(rows, columns_of(sys.stdout))
        print_result(files, lines, as_json=request.json)
        return ExitCode.OK
    copied = list(_copied(names, request.out))
    line = f"{request.out}: {len(copied)} {'file' if len(copied) == 1 else 'files'}"
    print_result(copied, [line], as_json=request.json)
    return ExitCode.OK


def _names() -> Iterator[str]:
    """Yield the files by their names in a clone."""
    for folder in FOLDERS:
        for path in sorted(shipped(folder).iterdir()):
            if path.is_file():
                yield path.relative_to(HOME).as_posix()


def _is_one(name: str, words: tuple[str, ...]) -> bool:
    return name in words or Path(name).name in words or Path(name).parts[0] in words


def _copied(names: list[str], out: Path) -> Iterator[Path]:
    for name in names:
        target = out / name
        with writing(target.parent):
            target.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(target) as part:
            part.write_bytes(shipped(name).read_bytes())
        yield target


def first_words(path: Path) -> str:
    """Return the first line that says what a file is; empty if it has none."""
    words = FIRST_WORDS.search(path.read_text(encoding="utf-8")[:HEAD])
    return words[1].strip().removesuffix("-->").strip() if words else ""
