"""A disk with 21 legs, and how many of 1000 random poses the model has an answer for.

python examples/model_disk.py disk.png
"""

import sys

import numpy as np

from model.quasistatic.frames import solve_frames
from model.systems.disk import WEIGHT_N, disk, disk_contact, random_disk_poses
from model.systems.predict import predict
from robot.study.model_plots import draw_predictions

LEGS = 21
poses = random_disk_poses(1000, LEGS, np.random.default_rng(0))
solutions = solve_frames(poses, disk_contact(LEGS), WEIGHT_N)
print(f"{solutions.valid.sum()} of 1000 random poses have an answer")
print(f"{solutions.contact.sum(axis=1).mean():.1f} of {LEGS} feet carry load on average")
draw_predictions([predict(disk(LEGS))]).savefig(sys.argv[1], dpi=90)
