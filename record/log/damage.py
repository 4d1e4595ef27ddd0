"""How far a pass over a log has come, and what of the file could not be read. Imports nothing heavy."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

NAMED = 3  # places of damage that a sentence names, if there are more than one besides


@dataclass(frozen=True, slots=True)
class Damage:
    """A part of a file that could not be read.

    Attributes:
        offset: Where it begins [bytes].
        size: Its length [bytes]; 0 when it goes on to the end of the file.
        from_ns: UNIX time of the last message before it (of the damaged chunk's own beginning, where its
            header is believable); -1 when there is none.
        to_ns: UNIX time of the first message after it (of the chunk's own end); -1 when nothing follows.
        reason: What is wrong, in words.
        content: Whether messages are lost; False if only an index or a checksum is wrong.
    """

    offset: int
    size: int
    from_ns: int
    to_ns: int
    reason: str
    content: bool = True

    def words(self, start_unix_ns: int) -> str:
        """Return reason, place and span of time in seconds since the log's beginning."""
        size = f", {self.size} bytes" if self.size else ""
        where = f"{self.reason} (at byte {self.offset}{size}"
        if not self.content:
            return f"{where}; no message is lost)"
        if self.from_ns < 0:
            return f"{where})"
        first_s, last_s = ((ns - start_unix_ns) * 1e-9 for ns in (self.from_ns, self.to_ns))
        end = f"to {last_s:.2f} s" if self.to_ns >= 0 else "on"
        return f"{where}; from {first_s:.2f} s {end})"


@dataclass(slots=True)
class Pass:
    """How far a pass over a file has come; filled while it is read.

    Attributes:
        size: Size of the file [bytes].
        position: Bytes read so far.
        finished: Whether the file has its proper end.
        damages: What could not be read, in file order.
        tell: Called now and then while it goes on.
    """

    size: int = 0
    position: int = 0
    finished: bool = False
    damages: list[Damage] = field(default_factory=list)
    tell: Callable[[], None] = lambda: None

    def begin_again(self) -> None:
        """Forget what a pass has found, for another one over the same file."""
        self.position, self.finished = 0, False
        self.damages.clear()


def damage_words(damages: Collection[Damage], start_unix_ns: int) -> str:
    """Return one sentence about the damage, times in seconds since the log's beginning; "" for none.

    Of many places it names the first, and counts the others.
    """
    if not damages:
        return ""
    every = [damage.words(start_unix_ns) for damage in damages]
    if (more := len(every) - NAMED) > 1:
        every[NAMED:] = [f"and {more} more places, which bigant log info lists"]
    return "cut or damaged: " + "; ".join(every)
