"""A hexapod over a bump: up 30 mm, down 50 mm.

python examples/model_stairs.py stairs.png
"""

import sys

import numpy as np

from model.systems.predict import predict
from model.systems.stairs import Steps, climb
from robot.study.model_plots import draw_predictions

bump = Steps(edges_x_m=np.array([0.5, 1.0]), heights_m=np.array([0.0, 0.03, -0.02]))
prediction = predict(climb(bump, cycles=18))
height = prediction.solutions.pose[:, 2]
print(
    f"{prediction.poses[-1, 0]:.2f} m forward, body {1e3 * (height[-1] - height[0]):.0f} mm higher"
)
draw_predictions([prediction]).savefig(sys.argv[1], dpi=90)
