"""Whether something vibrates, or a joint hunts."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, THEORY, Constant

ONE_HUNTED = "in 308 sealed cases (labels open) the only one with that fault is found, and no other"

STEADY_SCATTER = Constant(
    0.2, "scatter of the logarithm of a vibration's power where nothing vibrates more",
    "on the 19 realities (seeds 3109 and 3221, labels open): 259 cases without stiction",
)  # fmt: skip
VIBRATES_BY = Constant(
    1.5, "logarithm by which an effect that vibrates raises that power",
    "on the same cases: eight with stiction, 1.0 to 2.6; a soft mat hid the ninth",
)  # fmt: skip
VIBRATES_SCATTER = Constant(0.7, "scatter of that logarithm", "on the same cases")
VIBRATES_FREE = Constant(
    4.0, "degrees of freedom of the scatter of a vibration, or of a joint that hunts: others shake it, too",
    "the tail of Student's t that the same cases have; fewer is a heavier one",
)  # fmt: skip
VIBRATES_UNLIKE = Constant(
    1.0, "scatter of that logarithm between conditions where no two references tell it", BY_HAND
)
VIBRATION_CLEAR = Constant(
    2.3,
    "log likelihood from which vibration, or its absence, tells two effects apart: ten to one",
    THEORY,
)
VIBRATES_LEAST = Constant(
    0.1,
    "smallest size, in spreads, at which a cause that surely vibrates is named",
    "by hand: of eight cases with stiction whose feet surely vibrate (labels open) the least had 0.17",
)
HUNTS_BY = Constant(
    2.0, "how much more a joint swings in the trials than in any reference, to hunt as they do not",
    "by hand: with more play in its gear a joint swings 6 to 10 times as much, without none does",
)  # fmt: skip
HUNTS_SCATTER = Constant(
    0.2, "scatter between days of the logarithm of how far a joint swings that hunts",
    "by hand: it is 0.03 in references of one reality",
)  # fmt: skip
HUNTS_SLOWEST_HZ = Constant(
    3.0,
    "frequency [Hz] above which a joint's motion is no gait's",
    "gaits of all machines here are slower",
)
HUNTS_FASTER = Constant(
    1.5, "times that, which hunting is faster than: blows and pauses leave most just above",
    ONE_HUNTED,
)  # fmt: skip
HUNTS_SWINGS = Constant(
    10.0, "half periods on end that say that a joint hunts; a blow or a change of load brings fewer",
    ONE_HUNTED,
)  # fmt: skip
HUNTS_FEW_SWINGS = Constant(
    4.0, "half periods on end in which a joint that is known to hunt does so", BY_HAND
)
HUNTS_EVEN = Constant(
    2.0, "how many times as long, or short, as the middle half period one may be: readings cut some",
    BY_HAND,
)  # fmt: skip
HUNTS_KEEPS = Constant(
    0.5, "share of its height that hunting keeps at the end of a run of swings; what rings does not",
    BY_HAND,
)  # fmt: skip
HUNTS_NOISE = Constant(6.0, "standard deviations of a reading that a swing has", BY_HAND)
HUNTS_SELDOM = Constant(0.1, "share of the time below which a joint does not hunt", BY_HAND)
HUNTS_ALWAYS = Constant(
    0.75,
    "share of the time above which it is noise: under load a shaft lies against a flank",
    BY_HAND,
)
HUNTS_AT_REST = Constant(
    0.25, "share of its height left at other times, above which it is noise", BY_HAND
)
HUNTS_AROUND_S = Constant(
    0.25, "time [s] before and after in which the joint is not compared either: hunting comes and goes",
    BY_HAND,
)  # fmt: skip
VIBRATES_FASTER = Constant(
    1.0 / 3.0,
    "share of the frames a second above which a channel's motion is vibration",
    BY_HAND_LATER,
)
CALM_LEAD = Constant(
    2.0, "how much of a lead over channels that should be calm counts: all of one of a half and more",
    BY_HAND_LATER,
)  # fmt: skip
