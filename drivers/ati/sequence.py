"""Sequence numbers of records: what is fresh, what is lost, what is a unit that restarted.

A record behind the newest one is late and never fresh. But a unit that was switched off and on counts from
the beginning, which looks like late records for as long as it had counted: so when records keep coming in
order behind the newest, they are the new stream. A jump that no network makes is accepted when a second
record agrees with it: one damaged number must not make the whole stream look old.
"""

import enum

from drivers.ati.packets import U32

# A jump of the sequence number further than this is a unit that restarted, or a damaged number.
RESTART_JUMP = 100_000
# So many samples missing at once are accepted only when the next record agrees: four seconds at 250 Hz.
LARGEST_GAP = 1000
# So many records in order, behind the newest: the unit has restarted. A network delivers no such run.
RESTART_RUN = 5


class Arrival(enum.Enum):
    """What the sequence number of a record says about it."""

    NEXT = 0
    AFTER_GAP = 1
    DUPLICATE = 2
    LATE = 3
    RESTART = 4

    @property
    def fresh(self) -> bool:
        """Whether the record is newer than everything before."""
        return self is not Arrival.DUPLICATE and self is not Arrival.LATE


def classify(sequence: int, last: int) -> tuple[Arrival, int]:
    """Compare a sequence number with the highest one so far; both wrap at 2^32.

    Returns:
        What it is, and how many samples are missing before it.
    """
    step = (sequence - last + U32 // 2) % U32 - U32 // 2
    if abs(step) > RESTART_JUMP:
        return Arrival.RESTART, 0
    if step == 1:
        return Arrival.NEXT, 0
    if step > 1:
        return Arrival.AFTER_GAP, step - 1
    return (Arrival.DUPLICATE if step == 0 else Arrival.LATE), 0


class SequenceWatch:
    """Judges the records of one stream."""

    def __init__(self) -> None:
        self._newest: int | None = None
        self._jumped: int | None = None  # a number far away, not accepted yet
        self._behind: int | None = None
        self._run = 0

    def judge(self, sequence: int) -> tuple[Arrival, int]:
        """Return what a record is by its number (u32), and how many samples are missing before it.

        A jump, or a large gap, is ``LATE`` until a second record agrees with it.
        """
        arrival, missing = Arrival.NEXT, 0
        if self._newest is not None:
            arrival, missing = classify(sequence, self._newest)
        far = arrival is Arrival.RESTART or missing > LARGEST_GAP
        if far and not self._agrees(sequence):
            self._jumped = sequence
            return Arrival.LATE, 0
        if arrival is Arrival.LATE:
            in_order = self._behind is not None and (sequence - self._behind) % U32 == 1
            self._run = self._run + 1 if in_order else 1
            self._behind = sequence
            if self._run >= RESTART_RUN:
                arrival = Arrival.RESTART
        if arrival.fresh:
            self._newest = sequence
            self._behind, self._run = None, 0
            self._jumped = None
        return arrival, missing

    def _agrees(self, sequence: int) -> bool:
        """Whether a number goes on from the one that jumped; some in between may be lost."""
        if self._jumped is None:
            return False
        return 0 < (sequence - self._jumped) % U32 <= RESTART_JUMP
