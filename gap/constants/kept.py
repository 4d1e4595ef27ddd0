"""Whether a cause is kept, and which alternatives to it stay open."""

from gap.constants.constant import BY_HAND, DEVELOPMENT, THEORY, Constant

HELD_OUT_WORSE = Constant(
    2.0,
    "standard errors by which a cause must make held-out runs worse to be dropped for it",
    THEORY,
)
HELD_OUT_ADDS = Constant(
    0.005, "share of the gap that a cause must add to the others on held-out runs",
    "less than the shares are rounded to",
)  # fmt: skip
HELD_OUT_MOST = Constant(
    0.5,
    "share of what its channels show in the median cycle of held-out runs, each stage fed what was"
    " measured, that keeps a cause with references; without references, the share of held-out runs from"
    " which one that gains little of the whole is named",
    "a convention: more than half",
)
HELD_OUT_STAGE = Constant(
    0.05, "share of the held-out score, each stage fed what was measured, that keeps a cause all the same",
    "on two of the 19 realities (seed 3109, labels open, without references)",
)  # fmt: skip
SIZEABLE = Constant(
    0.9, "spreads from which a cause needs but a part of that share (next), without references",
    "on five of the 19 realities (seed 8801, labels open): true causes 0.95 and more, mimics up to 0.91",
)  # fmt: skip
HELD_OUT_SIZEABLE = Constant(0.03, "that share, for a cause of such a size", "with the one before")
LEAST_SIZE = Constant(
    0.5, "spreads below which a cause must add to the whole, not only to its stage, without references",
    "on five of the 19 realities (seed 8801, labels open): mimics of a wrong simulator are mostly smaller",
)  # fmt: skip
LEAST_SHARE = Constant(
    0.02, "share of the score of its channels that a cause must explain, without references",
    "on the servos of an SO-101 arm",
)  # fmt: skip
REST_SHARE = Constant(
    0.24, "share of the score beyond healthy runs', in its channels, that one more cause must explain",
    DEVELOPMENT,
)  # fmt: skip
NOT_BUILT = Constant(
    2.0,
    "spreads from which a cause is larger than machines are built with, so that it needs but the next two "
    "shares, without references",
    "on the 19 realities (two sets, labels open): three true causes of 2.1 to 4.1 spreads that were missed "
    "close 0.21 to 0.75 and 0.15 to 0.38; of 19 healthy robots none showed such a cause",
)
NOT_BUILT_SHARE = Constant(
    0.2,
    "share of the score of its channels that a cause of such a size must explain",
    "with the one before",
)
NOT_BUILT_HELD = Constant(
    0.1, "the same of held-out runs, each stage fed what was measured", "with the one before"
)
PLACE_SHARE = Constant(
    0.5, "share of its gain that a cause at a place must lose if it acts everywhere, without references",
    "a convention: half",
)  # fmt: skip
CLEAR_ERRORS = Constant(
    2.0, "standard errors, over many blocks, from which an advantage is more than scatter", THEORY
)
CONTAINS_SHARE = Constant(
    0.5, "share of what a new cause explains that a better one must explain to be named for it",
    "a convention: half",
)  # fmt: skip
TRIMMED = Constant(
    0.03, "share of the blocks, the worst, that a verdict does not depend on", DEVELOPMENT
)
WORTH_NATS = Constant(
    4.0,
    "log likelihood that a cause must gain on held-out blocks, and one more a parameter",
    BY_HAND,
)
HIDDEN_SHARE = Constant(
    0.05,
    "share of the remaining misfit that may hide an alternative, which therefore stays open",
    DEVELOPMENT,
)
STILL_LIKELY = Constant(
    0.2,
    "probability from which an alternative stays open, however much worse it predicts",
    "a convention: one in five",
)
MOSTLY = Constant(
    0.5,
    "share of the gap that causes must explain on held-out runs, without references, or it is unexplained",
    "a convention: more than half",
)
IN_DOUBT_SHARE = Constant(
    0.05,
    "share of what is explained that causes with open alternatives may have in an `explained`",
    "less than a reader would act on; the causes are listed with their alternatives all the same",
)
ACTS = Constant(
    0.1, "share of the largest gain of a channel from which a cause acts in a channel", BY_HAND
)
AHEAD_NATS = Constant(
    2.0, "log likelihood by which a candidate must be better to take a cause's place", THEORY
)
