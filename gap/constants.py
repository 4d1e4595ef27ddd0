"""Every number that was set by hand and decides something in a diagnosis, with where it comes from.

``docs/gap_constants.md`` has the table. A number that only limits effort (how many candidates are fitted)
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
ONE_HUNTED = "in 308 sealed cases (labels open) the only one with that fault is found, and no other"

# is a cause new, is there a gap?
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
    "the share that is taken for laws of contact is 0.03 (FORCES_DIFFER); 33 pairs, labels open",
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
NEARLY_AS_SURE = Constant(
    10.0,
    "times the chance of the surest change in a run, up to which others are listed with it",
    THEORY,
)
SHOWN = Constant(0.9, "share of such causes that a size said to be visible would show", THEORY)

# what is fitted to
EXCHANGED_FROM = Constant(
    10.0, "times the energy of any fitted run, in the median cycle, from which a held-out run is fitted",
    "a faster gait has a few times as much",
)  # fmt: skip
NO_ANSWER = Constant(
    3.0, "noise that a frame costs in which a cause leaves the simulator without an answer", BY_HAND
)

# is it kept?
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

# what is expected without a cause
MOST_INFLATION = Constant(
    4.0,
    "most that the expected variance is raised where references predict each other badly",
    BY_HAND,
)
ASSUMED_MISFIT = Constant(
    0.1,
    "share of the misfit that is expected where no reference shows it",
    "on the servos of an SO-101 arm",
)
GAIT_CORRELATION = Constant(0.4, "correlation of the misfits of two gaits", DEVELOPMENT)
FEW_RATIO = Constant(
    0.1,
    "repeat variance over misfit variance where fewer than three references tell it",
    DEVELOPMENT,
)
TRAPPED_RATIO = Constant(
    1.0,
    "repeat variance over misfit variance, at least, of forces that sticking feet hold against each other",
    DEVELOPMENT,
)
SAME_FREQUENCY = Constant(
    0.08,
    "change of frequency (natural log) up to which two runs are repeats of one command",
    BY_HAND,
)
LOG_FREQUENCY = Constant(
    0.5, "change of frequency (natural log) over which misfits stay correlated", DEVELOPMENT
)
TAIL = Constant(4.0, "energy over expectation from which a block counts by its logarithm", BY_HAND)
WHOLE_SHARE = Constant(
    0.7, "share of the channels that a simulator fed what was measured must answer", BY_HAND
)

# what the healthy machine shows already
LAW_SHARE = Constant(
    0.01, "share of the score of its channels that a baseline model error explains", DEVELOPMENT
)
LAW_GAIN = Constant(
    0.04, "share of the whole score that a baseline model error explains", DEVELOPMENT
)
SENSOR_GAIN = Constant(0.01, "the same of a delay or gain of a sensor", DEVELOPMENT)

# how sure
MEAN_DIFFERS = Constant(
    1.0,
    "spreads that are added to the +- of the static friction of feet that stick and slip (in squares): "
    "their mean grip tells little of it",
    "on twelve cases with stiction (labels open) it was off by 0 to 0.56, a spread being 0.3",
)
FORCES_DIFFER = Constant(
    0.03,
    "share of a cause's size that is added to its +-, where it acts through forces or is read from "
    "them: laws of contact, friction and springs are only nearly those of the machine",
    "on the 19 realities (seed 1127, labels open)",
)
MODELS_DIFFER = Constant(
    0.005,
    "the same of a cause that acts through what is measured or drawn: angles, lengths, times",
    "on the 19 realities (the two sets of 2026-11-26, labels open)",
)
PLACES_DIFFER = Constant(
    0.01,
    "the same of a place on the ground, as a share of its spread: half of a foot's width",
    "on the 19 development realities (seed 2201)",
)
TEMPERATURE = Constant(
    2.0, "log likelihood difference of two causes that counts as one", DEVELOPMENT
)
ERROR_SHARE = Constant(
    0.5, "share of that difference's standard error that is added to the temperature", DEVELOPMENT
)
MISFIT_SHARE = Constant(
    0.02,
    "share of the misfit beyond a healthy machine's that is added to the temperature",
    DEVELOPMENT,
)
GAIN_SHARE = Constant(
    0.01,
    "share of what the chosen cause gains that is added to the temperature: how an effect looks is itself "
    "known to some percent",
    "on a simulator written apart: a cause was 5.7 % behind another that was named instead of it",
)
NONE = Constant(
    -5.5,
    "log odds of none of the catalogue if the residual is as small as expected",
    DEVELOPMENT,
)
NONE_ENERGY = Constant(
    0.3, "added to them for each e-fold of energy over expectation that is left", DEVELOPMENT
)
NONE_OPEN = Constant(9.0, "added if none of the gap is explained, with references", DEVELOPMENT)
NONE_OPEN_ALONE = Constant(6.0, "the same without references", DEVELOPMENT)
NONE_WORST = Constant(
    0.25, "added for each e-fold of the worst channel's energy, with references", DEVELOPMENT
)
NONE_WORST_ALONE = Constant(0.1, "the same without references", DEVELOPMENT)
NONE_MANY = Constant(
    1.5,
    "added for each cause above two, with references",
    "on the 19 realities (seeds 3109 and 3221, labels open)",
)
NONE_ACTING = Constant(
    5.0,
    "added if causes close none of what no healthy run shows in the channels in which they act",
    "on 75 cases of 19 drawn realities (labels open), where 3 is likeliest; 8 on 106 cases of 19 kinds",
)
NONE_LEFT = Constant(
    4.0,
    "added for each e-fold of the energy left on held-out runs at the joint of a cause, beyond that at "
    "any other joint and a share of what the cause changes",
    "on the 19 realities (seeds 1127 and 1139, labels open)",
)
NONE_UNWATCHED = Constant(
    0.75,
    "added if no channel of a stage of the chain is measured, with references",
    "0.7 is likeliest on 19 drawn realities (labels open), 2.7 on seven with fewer sensors, less than "
    "0 on a robot that somebody else wrote",
)
FORM_DIFFERS = Constant(
    0.1,
    "share of its change by which an effect of a machine differs from the modelled one, before that counts "
    "as left",
    "on the 19 realities (seed 1127, labels open)",
)
ROUGH_CLOSES = Constant(
    0.5, "share of the gap that a cause of a roughly known form closes if nothing else is there",
    "four right ones (play, friction, give) close 0.3 to 0.6, two false ones 0.05 (labels open)",
)  # fmt: skip
ROUGH_DIFFERS = Constant(
    0.7,
    "the same of an effect that is rough: a shaft in its play bounces, friction differs with every gear",
    "on the 19 realities (seeds 1127 and 5151, labels open)",
)
SURELY_ODD = Constant(
    1e-4, "p-value of the residual below which it counts in full",
    "on 75 cases of 19 drawn realities (labels open), where 1e-5 is likeliest",
)  # fmt: skip
NONE_LIKELY = Constant(0.5, "probability of none above which a gap is unexplained", THEORY)
MOST_PART = Constant(
    1.1,
    "share of the gap above which no cause is given a part: one closes more than there is, others undo it",
    BY_HAND,
)
SURELY_MIRRORED = Constant(
    0.9,
    "correlation of the body's tilt with the opposite of the legs' above which the tilt is a severe fault",
    "on a simulator written apart, whose healthy robots leaned a little against their legs",
)
CLEAR_EXCESS = Constant(
    1.5, "energy over expectation from which a channel has a gap, even if no cause explains it",
    BY_HAND,
)  # fmt: skip
