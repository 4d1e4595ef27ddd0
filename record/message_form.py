"""An encoder for messages of one form: everything lies where it lay in an example.

``record.log.cdr`` asks of every value where it is and what is before it. In a run nearly all ticks are
alike: as many numbers in each sequence, texts of the same length. Then all gaps and lengths are known
beforehand, and a message is one joining of arrays, with the numbers between two of them packed at once. As
in ``record.log.fields``, the source of such a function is put together once and compiled.
"""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

ITEM_BYTES = {"BOOLS": 1, "INTS": 8, "FLOATS": 8}
# Lengths of sequences, packed; longer ones are not in any form.
COUNTS = tuple(struct.pack("<I", count) for count in range(256))


_VALUE = re.compile(r"\bvalue(?=\.)(?<!\.value)")


class MessagePart(NamedTuple):
    """What is written of a value; neighbours with equal ``put`` go in one call.

    Attributes:
        put: Method of ``CdrWriter``, kind of numbers in an array.
        letters: ``struct``'s, for ``CdrWriter.record``.
        sent: Expression of what to write, of a name ``value``.
    """

    put: tuple[str, str]
    letters: str
    sent: str

    def of(self, name: str) -> "MessagePart":
        """Return the same of another name."""
        return self._replace(sent=_VALUE.sub(name, self.sent))


class FormSource:
    """Puts the source of an encoder together, part by part.

    Args:
        header: What every message begins with.
        scope: What the parts' expressions need, values of the example and kinds of numbers included.
        varying: Expressions of sequences whose length may be another one, but not zero.
    """

    def __init__(
        self, header: bytes, scope: Mapping[str, Any], varying: frozenset[str] = frozenset()
    ) -> None:
        self._scope = {**scope, "counts": COUNTS}
        self._varying = varying
        self._place = 0  # without the header, which alignment does not count
        self._codes: list[str] = []  # numbers that are packed together, and the gaps before them
        self._values: list[str] = []
        self._joined = [repr(header)]
        self._bytes: list[str] = []
        self._kinds: dict[str, list[str]] = {}  # expressions of arrays
        self._sizes: dict[int, list[str]] = {}  # names of their bytes
        self._texts = 0

    def add(self, parts: Sequence[MessagePart]) -> None:
        """Add what is written of a value whose name is in the scope."""
        for part in parts:
            method, kind = part.put
            if method == "record":
                self.numbers(part.letters, part.sent)
            elif method == "texts":
                self._text(part.sent)
            else:
                self._array(part.sent, kind, counted=method == "sequences")

    def numbers(self, letters: str, values: str) -> None:
        """Add numbers, ``struct``'s letters."""
        for letter in letters:
            self._align(struct.calcsize("<" + letter))
            self._codes.append(letter)
            self._place += struct.calcsize("<" + letter)
        self._values.append(values)

    def _align(self, size: int) -> None:
        gap = -self._place % size
        if gap:
            self._codes.append(f"{gap}x")
        self._place += gap

    def _text(self, expression: str) -> None:
        """Add a text, whose bytes are an argument of their own: their length may differ by eights."""
        self._align(4)
        self._put(f"texts[{self._texts}]", len(eval(expression, self._scope).encode()) + 5)
        self._texts += 1

    def _array(self, expression: str, kind: str, *, counted: bool) -> None:
        size, example = ITEM_BYTES[kind], eval(expression, self._scope)
        name, varies = f"bytes_{len(self._bytes)}", expression in self._varying
        count = example.size
        if counted:
            self._align(4)
            if varies and count:
                self._put(f"counts[len({name}) >> 3]", 4)
            else:
                self.numbers("I", str(count))
        array = f"array_{len(self._bytes)}"
        self._bytes.append(f"{name} = ({array} := {expression}).tobytes()")
        self._kinds.setdefault(kind, []).append(array)
        if not (varies and count):
            self._sizes.setdefault(count * size, []).append(name)
        if count:
            self._align(size)
            self._put(name, count * size)

    def _put(self, expression: str, size: int) -> None:
        self._pack()
        self._joined.append(expression)
        self._place += size

    def _pack(self) -> None:
        """End a run of numbers: packed when the message is made, or now if all are known."""
        if not self._codes:
            return
        packed, values = struct.Struct("<" + "".join(self._codes)), ", ".join(self._values)
        if all(value.isdigit() for value in self._values):
            self._joined.append(repr(packed.pack(*map(int, self._values))))
        else:
            name = f"pack_{len(self._joined)}"
            self._scope[name] = packed.pack
            self._joined.append(f"{name}({values})")
        self._codes, self._values = [], []

    def made(self, arguments: str, before: Sequence[str]) -> Callable[..., bytes | None]:
        """Return the encoder.

        Args:
            arguments: Its arguments; the last is ``texts``, the bytes of all texts in their order.
            before: What it does first: gives the expressions their names.

        Returns:
            A function that returns a message, or None if an array is of another kind or length.
        """
        self._pack()
        lines = [f"def encode({arguments}):", *before, *self._bytes]
        alike = [f"{' is '.join(f'{one}.dtype' for one in names)} is {kind}"
                 for kind, names in self._kinds.items()]  # fmt: skip
        alike += [
            " == ".join([*(f"len({one})" for one in names), str(size)])
            for size, names in self._sizes.items()
        ]
        lines.append(f"if not ({' and '.join(alike)}): return None")
        lines.append(f"return b''.join(({', '.join(self._joined)},))")
        exec("\n ".join(lines), self._scope)
        encode: Callable[..., bytes | None] = self._scope["encode"]
        return encode
