"""A slithering body: the more grip it has across itself than along, the further it gets.

python examples/model_slither.py slither.png
"""

import sys

from model.systems.predict import predict
from model.systems.slither import slither
from robot.study.model_plots import draw_predictions

for across in (0.0, 1.0, 3.0, 10.0):
    way = predict(slither(cycles=2, across=across)).poses[-1, 0]
    print(f"traction across {1 + across**2:5.0f} times that along: {way * 1e3:4.0f} mm in 2 waves")
draw_predictions([predict(slither())]).savefig(sys.argv[1], dpi=90)
