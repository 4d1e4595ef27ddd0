"""How sure numbers and causes are, and whether none of the catalogue is right."""

from gap.constants.constant import BY_HAND, BY_HAND_LATER, DEVELOPMENT, THEORY, Constant

MEAN_DIFFERS = Constant(
    1.0,
    "spreads that are added to the +- of the static friction of feet that stick and slip (in squares): "
    "their mean grip tells little of it",
    "on twelve cases with stiction (labels open) it was off by 0 to 0.56, a spread being 0.3",
)
FORCES_DIFFER = Constant(
    0.02,
    "share of a cause's size that is added to its +-, where it acts through forces or is read from "
    "them: laws of contact, friction and springs are only nearly those of the machine",
    "numbers of 55 single causes of the 19 realities (seed 156425454, labels open): with 0.03, and 0.005 "
    "for the next, 85 % were within one +-, and 3 % of what a sensor is turned by was ten times too much",
)
MODELS_DIFFER = Constant(
    0.003,
    "the same of a cause that acts through what is measured or drawn: angles, lengths, times",
    "the same numbers, with which the two shares were chosen together",
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
    "share of what the chosen cause gains that is added to the temperature, and that a place must be "
    "worth: how an effect looks is itself known to some percent",
    "on a simulator written apart: a cause was 5.7 % behind another that was named instead of it. Friction "
    "of the whole floor was named as a patch of it for 0.02 and 0.3 % (labels open), true patches gain "
    "80 % more",
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
EXCESS_ERRORS = Constant(
    5.0,
    "standard errors, by the number of independent frames, that such an excess must be from 1 as well, "
    "without references",
    BY_HAND,
)
MOST_LEFT = Constant(
    3.0, "most that the energy left at the joint of a cause counts, in e-folds", BY_HAND_LATER
)
