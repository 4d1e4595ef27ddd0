"""What remains at the joint of a named cause.

Where a cause is all that is new, what is left of its own joint's channels is no clearer than what is left
elsewhere. It stays clearest there if a second cause is at that joint, or if the cause is only like the true
one. In 104 cases of 19 realities (2026-11-26, labels open) this held for four of nine causes outside the
catalogue that had been called another cause of the catalogue, for two pairs of which one cause was missed,
and for none of the answers that were whole.
"""

from collections.abc import Iterator, Sequence

from gap.diagnosis.findings import NamedCause
from gap.diagnosis.where import Where

CLEAR = 10.0  # standard errors of a mean, the largest of some hundred of them
AHEAD = 1.3  # times the clearest elsewhere


def left_there_words(named: Sequence[NamedCause], remaining: Where) -> Iterator[str]:
    """Say for each joint of a named cause if what remains is clearest there, one sentence each."""
    causes = {joint: one.effect for one in reversed(named) for joint in one.joints}
    for joint, effect in causes.items():
        here = [cell for cell in remaining.cells if cell.joint == joint]
        size = max((abs(cell.statistic) for cell in here), default=0.0)
        elsewhere = (abs(cell.statistic) for cell in remaining.cells if cell.joint not in causes)
        if size < max(CLEAR, AHEAD * max(elsewhere, default=0.0)):
            continue
        clearest = max(here, key=lambda cell: abs(cell.statistic))
        yield (
            f"what remains is clearest at {joint} ({clearest.channel}, {size:.0f} standard errors): a "
            f"second cause is there, or one that {effect} is only like"
        )
