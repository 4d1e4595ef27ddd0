"""A multipod on leaf springs: find its unloaded feet behind the deflected ones, then predict it.

python examples/model_multipod.py multipod.png
"""

import sys
from dataclasses import replace

import numpy as np

from model.systems.multipod import deflect, extrapolate_unloaded, multipod, multipod_segments
from model.systems.predict import predict
from model.values.legs import FootMotion
from robot.study.model_plots import draw_predictions

true = multipod(12)
load = predict(true).solutions.load_n
seen = deflect(true.feet.position_m, load, true.contact.stiffness)  # what motion tracking would see
found = extrapolate_unloaded(seen, load > 0, multipod_segments(12, true.time_s))
print(f"springs give way by up to {np.abs(seen - true.feet.position_m).max() * 1e3:.1f} mm")
print(f"unloaded feet are found to {np.abs(found - true.feet.position_m).max() * 1e3:.4f} mm")
system = replace(true, feet=FootMotion(found, np.gradient(found, true.step_s, axis=0)))
draw_predictions([predict(system)]).savefig(sys.argv[1], dpi=90)
