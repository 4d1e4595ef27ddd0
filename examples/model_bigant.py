"""BigANT in its slipping gait: the paper's friction against Coulomb's, drawn over each other.

python examples/model_bigant.py bigant.png
"""

import sys

import bigant
from robot.study.model_plots import draw_predictions

predictions = [bigant.predict("metachronal", law=law) for law in ("viscous", "coulomb")]
for prediction in predictions:
    print(f"{prediction.law.value}: {prediction.poses[-1, 0] * 1e3:.0f} mm forward")
draw_predictions(predictions).savefig(sys.argv[1], dpi=90)
