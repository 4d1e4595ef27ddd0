"""What is fitted to, and which candidates are fitted."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, Constant

EXCHANGED_FROM = Constant(
    10.0, "times the energy of any fitted run, in the median cycle, from which a held-out run is fitted",
    "a faster gait has a few times as much",
)  # fmt: skip
NO_ANSWER = Constant(
    3.0, "noise that a frame costs in which a cause leaves the simulator without an answer", BY_HAND
)

NEAR_BEST = Constant(
    0.2,
    "share of the best candidate's gain, to first order, below which one is not fitted",
    BY_HAND,
)
FIRST_NATS = Constant(
    0.5, "log likelihood that a candidate must gain to first order to be fitted", BY_HAND
)
SECOND_NATS = Constant(
    10.0, "the same in a second list, for what is not near the best, with references", BY_HAND_LATER
)
SURELY_USUAL = Constant(
    0.05,
    "chance by itself, to first order, from which healthy runs surely show a further cause as well, so "
    "that it is not fitted",
    BY_HAND_LATER,
)
MUCH_LESS = Constant(
    0.5, "share of a fit's energy; where least squares would leave less, the fit begins again there",
    BY_HAND_LATER,
)  # fmt: skip
NEAR_AS_GOOD = Constant(
    0.8,
    "share of a cause's gain, to first order, from which a candidate is tried in its place",
    BY_HAND_LATER,
)
HOPELESS = Constant(
    0.3, "share of a cause's gain by which another in its place may be behind after one round of a fit",
    BY_HAND_LATER,
)  # fmt: skip
MAY_REACH = Constant(
    0.7,
    "share of the size and of the part of its channels that a cause must have, without references, that a "
    "candidate must have before it is fitted",
    BY_HAND_LATER,
)
NOTHING_LEFT = Constant(
    1.2,
    "energy over expectation, little more than that of healthy runs, below which signatures stay those of "
    "the simulator without causes",
    BY_HAND,
)
MADE_AGAIN = Constant(
    0.3, "share of the score that a cause must close for signatures to be made again", BY_HAND
)
