"""Sequence numbers of records: what is fresh, what is lost, what is a unit that started anew.

A record behind the newest one is late and never fresh. But a unit that was switched off and on counts from
the beginning, which looks like late records for as long as it had counted: so when records keep coming in
order behind the newest, they are the new stream.
"""

from dataclasses import dataclass

from drivers.ati.packets import U32, Arrival, classify

# So many records in order, behind the newest: the unit has started anew. A network delivers no such run.
RESTART_RUN = 5


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a sequence number says.

    Attributes:
        arrival: What the record is. Only NEXT, AFTER_GAP and RESTART are fresh.
        missing: Samples lost before it.
    """

    arrival: Arrival
    missing: int

    @property
    def fresh(self) -> bool:
        """Whether the record is newer than everything before."""
        return self.arrival in {Arrival.NEXT, Arrival.AFTER_GAP, Arrival.RESTART}


class SequenceWatch:
    """Judges the records of one stream."""

    def __init__(self) -> None:
        self._newest: int | None = None
        self._behind: int | None = None
        self._run = 0

    def judge(self, sequence: int) -> Verdict:
        """Judge one sequence number, u32."""
        if self._newest is None:
            return self._take(sequence, Arrival.NEXT, 0)
        arrival, missing = classify(sequence, self._newest)
        if arrival is Arrival.LATE:
            in_order = self._behind is not None and (sequence - self._behind) % U32 == 1
            self._run = self._run + 1 if in_order else 1
            self._behind = sequence
            if self._run >= RESTART_RUN:
                return self._take(sequence, Arrival.RESTART, 0)
            return Verdict(arrival, 0)
        if arrival is Arrival.DUPLICATE:
            return Verdict(arrival, 0)
        return self._take(sequence, arrival, missing)

    def _take(self, sequence: int, arrival: Arrival, missing: int) -> Verdict:
        self._newest = sequence
        self._behind, self._run = None, 0
        return Verdict(arrival, missing)
