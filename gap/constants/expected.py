"""What a run is expected to show without a cause."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, DEVELOPMENT, Constant

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
LAW_SHARE = Constant(
    0.01, "share of the score of its channels that a baseline model error explains", DEVELOPMENT
)
LAW_GAIN = Constant(
    0.04, "share of the whole score that a baseline model error explains", DEVELOPMENT
)
SENSOR_GAIN = Constant(0.01, "the same of a delay or gain of a sensor", DEVELOPMENT)

HARMONICS = Constant(
    36.0, "harmonics of the gait by which what repeats is described; what is beyond them counts as noise",
    "with six, and in part with twelve, sharp errors of servos that turn round or hurry were noise, and "
    "hid whether commands come late or a loop is slow",
)  # fmt: skip
LOW_HARMONICS = Constant(
    6.0, "harmonics up to which coefficients of a channel share how well they repeat", BY_HAND_LATER
)
MOTION_HARMONICS = Constant(
    100.0,
    "the same of a motion that a run makes once, all references alike: the whole run is its cycle",
    "with 36, a gear that rubs in a part of its turn was `no_gap` on a bench that others wrote",
)
MOTION_UNLIKE = Constant(
    0.1,
    "root mean square difference of two commands, over what they move, from which motions are unlike",
    BY_HAND_LATER,
)
FRAMES_A_PERIOD = Constant(3.0, "frames a period of the highest harmonic", BY_HAND_LATER)
SHORTEST_CYCLES = Constant(
    1.5, "cycles of a run from which its harmonics are measured", BY_HAND_LATER
)
OWN_POWER = Constant(
    0.5,
    "weight of a joint's own misfit in how large it may be, beside that of all joints together",
    "a convention: half",
)
ALL_ALIKE = Constant(
    8.0, "independent frames that a run has at least, however alike its frames are", BY_HAND_LATER
)
UNCORRELATED = Constant(0.1, "correlation of frames below which they count as independent", BY_HAND)
NOISIER = Constant(
    1.5,
    "times the noise of walking, from which the start of a run counts as noisier",
    BY_HAND_LATER,
)
