"""A lab's own effect in the simulator under diagnosis: which readings would show it, and by how much.

python examples/own_effect.py
"""

from pathlib import Path

import numpy as np

import bigant
from gap.interfaces import Cause, Drive
from robot.gap_report.trials import simulator_for

trial = bigant.walk_trial(cycles=0.3, frequency_hz=0.2)
simulator = simulator_for([trial], Path(__file__).with_name("worn_crank.py"))
measured = simulator.observe(trial)
healthy = simulator.predict(trial, (), Drive.COMMAND)
worn = simulator.predict(trial, (Cause("worn_crank", ("ML",), (0.002,)),), Drive.COMMAND)

change = np.sqrt(np.nanmean(((worn - healthy) / measured.noise) ** 2, axis=0))
print("2 mm of play in the crank of ML, in units of each reading's noise:")
for at in np.argsort(-np.nan_to_num(change))[:6]:
    channel = simulator.channels[at]
    print(f"  {channel.name} {channel.joint:<3} {change[at]:6.1f}")
