"""What each picture of the odometry page shows, in a sentence for somebody who has never seen it."""

PATH = """Where the robot was. Each ellipse should hold the true place in 95 of 100 cases. It grows from the
beginning of the walk on, unless something tells the estimator where it is."""
DISTANCE = """How far each method is from the truth. The dotted line is the error that the estimator expects
of itself: its own line should mostly stay below."""
ERRORS = """Against the ground truth; smaller is better. RPE and end are in % of the path; errors of
velocities and forces are root mean squares (RMSE)."""
VELOCITY = """Estimated minus true velocity. About 95 % of it should lie in the grey band; more outside
means that the estimator is overconfident."""
HEALTH = """What the estimator reports of itself: ok, degraded (it works, but doubts itself) or lost (the
place is a guess)."""
REASONS = "Each numbered row is a reason, listed below."
NO_REASON = "It had no reason for doubt."
NOTICED = """What the forces say of the robot file and the ground that is not as assumed. The estimate
allows for it; a better robot file would make it better."""
NOTHING_NOTICED = "The measurements say nothing against the robot file, nor of a slope."
NIS = """NIS compares what the sensors measured with what the filter expected, in units of the variance that
it expects; 1 is ideal. Above the band, sensors and filter disagree; below it, the filter allows for larger
errors than there are."""
NIS_BAND = """The band is that of errors that differ from tick to tick; errors that last longer leave it
more often, even if their size is right."""
NO_MEASUREMENT = """No measurement was used: the estimate rests on shafts and model alone, and nothing can
contradict it."""
REJECTED = """too far from what the filter expected (beyond the gate), so it rejected them. A few are
normal; many of one leg point to its sensor, its zero, or the ground under it."""
NOTHING_REJECTED = "Nothing: every measurement was near enough to what the filter expected."
NOTHING_TO_REJECT = "Nothing: there was no measurement that could have been."
NO_FORCES = "No foot forces were measured, so the predicted ones cannot be judged."
AXES = "x ahead, y to the left, z up. Where the lines part, the model of that foot is wrong."
LEGS = """What the estimator has learned of each leg; the shade is one standard deviation to either side. A
foot tells of its friction only while it slips, and of its stiffness only where forces are measured."""
OVERCONFIDENT = (
    "In good health all the time by its own report, but with a larger error than it claims"
)
NO_TRUTH = "This log has no ground truth, so nothing here is judged by one."
IMPORT_TRUTH = """This log has no ground truth, so no errors can be shown. Import the true poses with the
run: body_x_m, body_y_m and an orientation."""
MEANINGS = (
    ("estimator", "the filter that runs in the loop: it predicts by the model of slipping feet, corrected "
     "by what was measured"),
    ("open loop, naive", "the same model at the robot file's values, without any correction"),
    ("distance a stride", "a fixed length each cycle, straight ahead"),
    ("rigid stance", "velocity as if loaded feet never slipped"),
    ("RPE", "relative pose error: how far off the end of a piece of path of that length is, seen from its "
     "beginning, in % of the length; the mean over all such pieces"),
    ("end, yaw", "how far off place and heading are at the end, over the length of the path"),
    ("sd", "standard deviation, as the estimator says; 95 of 100 errors should be below 2 sd"),
    ("innovation", "what a sensor measured minus what the filter expected"),
    ("NIS", "innovation squared, in units of the variance that the filter expects; per degree of "
     "freedom, 1 is ideal"),
    ("NEES", "the same of the estimate's error against the ground truth; of three numbers, 3 is ideal"),
    ("gate", "the bound on an innovation beyond which the filter rejects the measurement"),
    ("mu, K", "friction coefficient and vertical stiffness of a leg"),
)  # fmt: skip
