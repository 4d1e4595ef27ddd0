"""Every number that was set by hand and decides something in a diagnosis, with where it comes from.

``docs/gap_constants.md`` has the table, with what half and twice of each does to the figures
(``python -m benchmarks gap_constants``). A number that only limits effort (how many candidates are fitted)
or that follows from theory is not here.
"""

__all__ = ("Constant",)


class Constant(float):
    """A number with its meaning and how it was chosen."""

    meaning: str
    chosen: str

    def __new__(cls, value: float, meaning: str, chosen: str) -> "Constant":
        """Make one; it is used as the number that it is."""
        made = super().__new__(cls, value)
        made.meaning, made.chosen = meaning, chosen
        return made

    def __reduce__(self) -> tuple[type["Constant"], tuple[float, str, str]]:
        """Travel to other processes as what it is made of."""
        return Constant, (float(self), self.meaning, self.chosen)


THEORY, BY_HAND, DEVELOPMENT = (
    "a convention", "by hand, before any campaign", "on development campaigns of the twin"
)  # fmt: skip

# is a cause new, is there a gap?
FALSE_ALARMS = Constant(
    0.02, "chance of a gap in a healthy machine, as far as references can promise it", THEORY
)
NULL_WORTH = Constant(
    2.0,
    "held-out references that a test's own promise is worth beside those that there are",
    BY_HAND,
)
JOINTS_DIFFER = Constant(
    0.25, "variance of the logarithm of joints' variances from day to day, where few joints show it",
    "joints whose standard deviations differ by 25 %",
)  # fmt: skip
JOINTS_DIFFER_WORTH = Constant(3.0, "joints that JOINTS_DIFFER is worth", BY_HAND)
JOINT_UNLIKE = Constant(
    0.1, "probability that a joint scatters from day to day like no other", BY_HAND
)
CHANNELS_APART = Constant(
    6.0, "channels of one run that count as independent where their scatter is pooled", DEVELOPMENT
)
LEAST_SCATTER = Constant(0.05, "least scatter of the logarithm of an energy between runs", BY_HAND)
SHOWN = Constant(0.9, "share of such causes that a size said to be visible would show", THEORY)

# what is fitted to
NO_ANSWER = Constant(
    3.0, "noise that a frame costs in which a cause leaves the simulator without an answer", BY_HAND
)

# is it kept?
HELD_OUT_WORSE = Constant(
    2.0,
    "standard errors by which a cause must make held-out runs worse to be dropped for it",
    THEORY,
)
LEAST_SHARE = Constant(
    0.02, "share of the score of its channels that a cause must close, without references",
    "on the servos of an SO-101 arm",
)  # fmt: skip
REST_SHARE = Constant(
    0.24, "share of the score beyond healthy runs', in its channels, that one more cause must close",
    DEVELOPMENT,
)  # fmt: skip
TRIMMED = Constant(
    0.03, "share of the blocks, the worst, that a verdict does not depend on", DEVELOPMENT
)
