"""Damage of files: bytes, lines, numbers, nesting, cuts. The same seed damages alike."""

import random
from collections.abc import Callable

TOKENS = (
    "nan", "inf", "-inf", "1e400", "-1", "0", "1e-300", "99999999999999999999", '""', "[]", "{}", "true",
    "''", "[[[[", "\x00", "\x1b[31m", "\N{SNOWMAN}", "[1, 2", "1979-05-27T07:32:00Z", "5" * 5000,
    "[" * 3000, "'" * 3,
)  # fmt: skip
NUMBER_CHARACTERS = set("0123456789.eE+-")


def damaged(data: bytes, random_source: random.Random) -> bytes:
    """Return data with one to four mutations."""
    for _ in range(random_source.choice((1, 1, 1, 2, 4))):
        change = random_source.choice(TEXT_CHANGES if _is_text(data) else BYTE_CHANGES)
        data = change(data, random_source)
    return data


def _is_text(data: bytes) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return b"\x00" not in data


def _flip(data: bytes, source: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(source.choice((1, 1, 8, 64))):
        if changed:
            changed[source.randrange(len(changed))] = source.randrange(256)
    return bytes(changed)


def _cut(data: bytes, source: random.Random) -> bytes:
    at = source.randrange(len(data) + 1)
    return source.choice((data[:at], data[at:], b""))


def _repeat(data: bytes, source: random.Random) -> bytes:
    begin, end = sorted(source.randrange(len(data) + 1) for _ in range(2))
    return data[:end] + data[begin : min(end, begin + 100_000)] + data[end:]


def _zero(data: bytes, source: random.Random) -> bytes:
    begin = source.randrange(len(data) + 1)
    length = source.choice((1, 8, 512))
    return data[:begin] + b"\x00" * length + data[begin + length :]


def _token(data: bytes, source: random.Random) -> bytes:
    """Put a token in the place of a number or anywhere."""
    text = data.decode(errors="replace")
    at = source.randrange(len(text) + 1)
    end = at
    if source.random() < 0.8:
        at = next((i for i in range(at, len(text)) if text[i].isdigit()), at)
        end = next((i for i in range(at, len(text)) if text[i] not in NUMBER_CHARACTERS), len(text))
    return (text[:at] + source.choice(TOKENS) + text[end:]).encode(errors="replace")


def _lines(data: bytes, source: random.Random) -> bytes:
    """Leave out, repeat or swap lines."""
    lines = data.split(b"\n")
    i, j = (source.randrange(len(lines)) for _ in range(2))
    what = source.randrange(3)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    else:
        lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


Change = Callable[[bytes, random.Random], bytes]
BYTE_CHANGES: tuple[Change, ...] = (_flip, _cut, _repeat, _zero)
TEXT_CHANGES: tuple[Change, ...] = (_token, _token, _lines, _flip, _cut, _repeat)
