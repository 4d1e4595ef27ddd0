"""Whether a cause is new, and whether there is a gap."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, DEVELOPMENT, THEORY, Constant

FALSE_ALARMS = Constant(
    0.05, "probability that a healthy machine is reported to have a gap (the aim)", THEORY
)
ENERGY_LEVEL = Constant(
    0.01, "chance of such energies in a healthy machine, below which they are a gap without any cause",
    "false alarms that are added to the aim where energies scatter as assumed; of 17 healthy robots drawn "
    "at random (labels open) the least chance was 0.08",
)  # fmt: skip
OPEN_LEVEL = Constant(
    0.2,
    "the same chance of a cause where energies show a gap already, or another cause is named; one above it "
    "by itself is not new beside what differs from day to day, either",
    "of 93 causes beside others in three sealed sets (labels open) none above 0.19 was right; nor one of "
    "four above 0.15 on a robot that somebody else wrote",
)
NULL_WORTH = Constant(
    12.0,
    "held-out references that a test's own promise is worth beside those that there are",
    "with 6, two of 237 sealed healthy robots had a gap, where the aim allows twelve",
)
JOINTS_DIFFER = Constant(
    0.25, "variance of the logarithm of joints' variances from day to day, where few joints show it",
    "joints whose standard deviations differ by 25 %",
)  # fmt: skip
JOINTS_DIFFER_WORTH = Constant(3.0, "joints that JOINTS_DIFFER is worth", BY_HAND)
DAY_WORTH = Constant(
    0.1, "healthy runs that it is worth that all parameters differ alike from day to day",
    "drag and turned force axes on open cases of four realities; 0.3 and 1 find less",
)  # fmt: skip
DAY_MEAN = Constant(
    2.0,
    "spreads by which the simulator's parameters may be wrong alike in all healthy runs",
    BY_HAND,
)
JOINT_UNLIKE = Constant(
    0.1, "probability that a joint's day-to-day scatter is unlike that of all others", BY_HAND
)
CHANNELS_APART = Constant(
    6.0, "channels of one run that count as independent where their scatter is pooled", DEVELOPMENT
)
LEAST_ENERGY = Constant(
    0.1, "energy over expectation, of all that is left of a run, that is as good as none",
    "of 76 healthy runs alone (references of 19 realities, labels open) one has a chance below 1 %, eight "
    "without it; 0.05 and 0.2 do the same",
)  # fmt: skip
JOINT_SHOWS = Constant(
    0.01, "share of a cause's energy at its joint, that it must have at another one to tell of its scatter",
    "an arm that somebody else wrote (labels open): what hardly shows at a vertical axis is noise there",
)  # fmt: skip
LEAST_SCATTER = Constant(
    0.05,
    "least scatter between runs of the logarithm of the energies of all channels together",
    BY_HAND,
)
CHANNEL_SCATTER = Constant(
    0.2,
    "the same of a channel: noise of a calm one differs a little from day to day, which is no gap",
    "on 17 healthy robots drawn at random (labels open): at 0.05 two had a chance below 0.02, at 0.2 none",
)
SHAPE_DIFFERS = Constant(
    0.05,
    "share of the change by other causes that one more must make to be tried beside what differs from day "
    "to day: they are only nearly of the machine's shape",
    "the share that was taken for laws of contact (FORCES_DIFFER), 0.03 then; 33 pairs, labels open",
)
UNSTEADY_LEVEL = Constant(
    0.01,
    "chance of so large a trend in a cause that changes by no more than that, below which it counts",
    "a fifth of the 5 % of listed causes that may be called unexplained",
)
UNSTEADY_GROWTH = Constant(
    0.2, "change over a run, as a share of a cause's size, that a simulator's error may look like",
    "on 269 cases (labels open): of 215 right causes two changed by more at 1 %, none surely by more",
)  # fmt: skip
CHANGE_LEVEL = Constant(
    0.01,
    "chance, among all that may wear, of so large a change in the course of a healthy machine's runs, "
    "below which it is a gap without any cause",
    "none of 51 healthy robots of 21 realities (labels open) had one below 0.05",
)
JOINTS_SHARE = Constant(
    0.2, "share of that level for all effects at single joints together", THEORY
)
LEAST_CHANGE = Constant(
    0.2, "spreads, to first order, below which such a change does not count", THEORY
)
NEARLY_AS_SURE = Constant(
    10.0,
    "times the chance of the surest change in a run, up to which others are listed with it",
    THEORY,
)
SHOWN = Constant(0.9, "share of such causes that a size said to be visible would show", THEORY)

CAUSES_PART = Constant(
    0.8,
    "share of the aim that the chance of causes has; the rest is for energies, which alone hardly ever "
    "reach their level in a healthy machine",
    "on healthy robots (2026-11-26, labels open); energies had half of it before, and used none",
)
FEWEST_CYCLES = Constant(
    2.5,
    "cycles of a run from which it is told whether a cause changes in its course",
    BY_HAND_LATER,
)
EVEN_CHANGE = Constant(
    0.5, "what is left of the probability of the catalogue by a change that is just at its level",
    "a convention: even odds",
)  # fmt: skip
