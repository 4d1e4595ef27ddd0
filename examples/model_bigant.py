"""BigANT in its slipping gait: the paper's friction against Coulomb's, drawn over each other.

python examples/model_bigant.py bigant.png
"""

import sys

from model.quasistatic.frames import FrictionLaw
from model.systems.predict import predict
from robot.study.model_plots import draw_predictions
from robot.study.systems import build_system

system = build_system("bigant", gait="metachronal", cycles=3)
predictions = [predict(system, law=law) for law in FrictionLaw]
for prediction in predictions:
    print(f"{prediction.law.value}: {prediction.poses[-1, 0] * 1e3:.0f} mm forward")
draw_predictions(predictions).savefig(sys.argv[1], dpi=90)
