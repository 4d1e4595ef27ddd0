"""A lab's own effect in the simulator under diagnosis: which readings would show it, and by how much.

python examples/own_effect.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from gap.interfaces import Cause, Drive
from robot.cli import main as cli
from robot.gap_report.trials import read_trials, simulator_for

with TemporaryDirectory() as folder:
    log = Path(folder) / "walk.mcap"
    cli.run(
        ["drive", "--virtual-time", "--duration", "1", "--frequency-hz", "0.2", "--log", str(log)]
    )
    trials = read_trials([log])

simulator = simulator_for(trials, Path(__file__).with_name("worn_crank.py"))
measured = simulator.observe(trials[0])
healthy = simulator.predict(trials[0], (), Drive.COMMAND)
worn = simulator.predict(trials[0], (Cause("worn_crank", ("ML",), (0.002,)),), Drive.COMMAND)

change = np.sqrt(np.nanmean(((worn - healthy) / measured.noise) ** 2, axis=0))
print("\n2 mm of play in the crank of ML, in units of each reading's noise:")
for at in np.argsort(-np.nan_to_num(change))[:6]:
    channel = simulator.channels[at]
    print(f"  {channel.name} {channel.joint:<3} {change[at]:6.1f}")
