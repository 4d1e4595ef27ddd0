"""A trotting quadruped, and the low pass that stands in for its inertia, chosen from spectra.

python examples/model_quadruped.py quadruped.png
"""

import sys
from dataclasses import replace

import numpy as np

from model.motion.low_pass import choose_gamma, low_pass
from model.systems.predict import predict
from model.systems.quadruped import quadruped
from robot.study.model_plots import draw_predictions

raw = predict(replace(quadruped(), low_pass=None))
predicted = raw.velocity_B[:, [0, 2]]  # straight ahead: there is no sideways velocity to compare
# a made-up measurement: the prediction as a heavier body would follow it, with noise
noise = np.random.default_rng(0).normal(0, 1e-3, predicted.shape)
gamma = choose_gamma(predicted, low_pass(predicted, 0.6) + noise, rate_hz=100.0)
print(f"gamma {gamma:.3f} brings the spectra together (0.6 was used)")
draw_predictions([predict(replace(raw.system, low_pass=gamma))]).savefig(sys.argv[1], dpi=90)
