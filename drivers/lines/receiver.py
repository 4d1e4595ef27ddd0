"""Lines of text turned into records: comments, stamps, lines without sense and floods of them."""

from collections.abc import Callable
from decimal import Decimal
from typing import Generic, Protocol, TypeVar

from drivers.clock import Clock
from drivers.lines.sources import LineSource
from model.values.faults import Fault, FaultKind

# A record that is older or newer than this is of no use; its stamp is in ms or ns, or a clock is wrong.
MOST_AWAY_S = 30.0


class Stamped(Protocol):
    """A record with a time."""

    @property
    def t_ns(self) -> int:
        """When it was measured, on the loop's clock."""
        ...


R = TypeVar("R", bound=Stamped)


def stamp_ns(word: str, offset_ns: int) -> int:
    """Return a UNIX time in seconds as time of the loop's clock.

    Args:
        word: The time as written; a float of seconds since 1970 is good to a quarter of a microsecond only.
        offset_ns: UNIX time less the loop's clock.
    """
    return int(Decimal(word) * 1_000_000_000) - offset_ns


class LineReceiver(Generic[R]):
    """Reads a source of lines; never waits.

    Args:
        source: Where the lines come from.
        parse: Makes a record of a line; ValueError says why one makes no sense.
        clock: The loop's clock.
        kind: Kind of fault of a line without sense.
        name: What it is, in the faults.
        most: Records in one read; of more the newest count.
    """

    def __init__(
        self,
        source: LineSource,
        parse: Callable[[str], R],
        clock: Clock,
        *,
        kind: FaultKind,
        name: str,
        most: int,
    ) -> None:
        self._source, self._parse, self._clock = source, parse, clock
        self._kind, self._name, self._most = kind, name, most

    def read(self) -> tuple[tuple[R, ...], tuple[Fault, ...]]:
        """Return what has come since the last read, and the first fault of it."""
        try:
            received = self._source.receive()
        except OSError as error:
            return (), (self._fault(str(error)),)
        lines = [line for line in received if line.strip() and not line.lstrip().startswith("#")]
        faults: list[Fault] = []
        if len(lines) > self._most:
            words = f"more than {self._most} lines in one period; only the newest are used"
            faults.append(self._fault(words))
        records: list[R] = []
        for line in lines[-self._most :]:
            try:
                records.append(self._timely(self._parse(line)))
            except (ValueError, ArithmeticError) as error:
                faults.append(self._fault(f"{line[:60]!r} makes no sense: {error}"))
        return tuple(records), tuple(faults[:1])

    def _timely(self, record: R) -> R:
        away_s = (record.t_ns - self._clock.now_ns()) * 1e-9
        if abs(away_s) > MOST_AWAY_S:
            raise ValueError(
                f"its time is {away_s:.3g} s from now; it has to be UNIX time in seconds"
            )
        return record

    def _fault(self, words: str) -> Fault:
        return Fault(self._kind, self._name, words)

    def close(self) -> None:
        """Give the source back."""
        self._source.close()
