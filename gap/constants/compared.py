"""What of a run is compared, and how much it weighs."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, Constant

HELD_OUT_SHARE = Constant(0.25, "share of the trials that are held out to judge", BY_HAND)
SHORTEST_BLOCK_S = Constant(
    1.0, "time [s] that a block has at least, so that blocks count as independent", BY_HAND
)
LAST_BLOCK = Constant(
    0.7, "share of the block before it from which the end of a run is a block of its own", BY_HAND
)
SETTLE_S = Constant(
    0.1,
    "time [s] from the start of a run in which a servo's or a joint's loop is not compared: its state "
    "before is not known",
    BY_HAND,
)

# legged robots
EDGE_S = Constant(
    0.3, "time [s] at both ends of a run that is not compared: filters differ there", BY_HAND
)  # fmt: skip
SWITCH_S = Constant(
    0.06, "time [s] about a foot's touching down or lifting off in which channels that feel it count less",
    BY_HAND,
)  # fmt: skip
SWITCH_WEIGHT = Constant(0.25, "weight of a frame there", BY_HAND)
CONTACT_N = Constant(1.0, "force [N] above which a foot is down", BY_HAND)
PULL_WEIGHT = Constant(
    0.1,
    "weight of a frame in which a foot's force is compared below 0, where it is compared as a force, too",
    BY_HAND_LATER,
)
PULL_SHARE = Constant(
    0.2, "share of the load of a loaded foot by which a foot's force is below 0, at least, where it pulls",
    "from 0 on, zeros of load cells that differ from day to day by 0.3 N were gaps of three of three "
    "healthy robots that others wrote",
)  # fmt: skip
MEAN_READINGS = Constant(
    1.0, "readings that the mean velocity of a window counts as",
    "with 24 it outvoted the frames, and causes that these show looked like days (p-values up to twenty "
    "times as large)",
)  # fmt: skip
GRIP_READINGS = Constant(
    24.0, "the same of a foot's grip, about as many as the forces that it is read from",
    "as one reading it was outvoted by forces of feet that stick, which no simulator predicts",
)  # fmt: skip
GRIP_LARGEST = Constant(
    0.95,
    "quantile of a foot's sideways share of its load, over a window, that is its grip",
    BY_HAND_LATER,
)
GRIP_LOADED = Constant(
    0.1, "share of the machine's weight from which a foot counts as loaded", BY_HAND_LATER
)
GRIP_WINDOW_S = Constant(
    4.0, "time [s] of a window at least: whole cycles of the gait", BY_HAND_LATER
)
GRIP_NOISE = Constant(
    0.05, "noise of the logarithm of a grip: a foot may not slip at all in a cycle", BY_HAND_LATER
)
