"""A lab's own effect: the crank's bearing is worn, so the foot rises and falls once a turn.

bigant gap effects --effects examples/worn_crank.py
bigant gap diagnose TRIAL... --effects examples/worn_crank.py
"""

from dataclasses import replace

import numpy as np

from gap.effect_file import UserEffect
from gap.interfaces import Effect, Parameter, Scope


def worn_crank(signals, values, legs):
    """Return the signals with the feet of some legs lifted by the play."""
    (play_m,) = values
    feet = signals.position_m.copy()
    feet[..., 2] += np.array(legs) * play_m * np.sin(signals.crank_rad)
    return replace(signals, position_m=feet)


EFFECTS = [
    UserEffect(
        Effect(
            name="worn_crank",
            stage="kinematics",
            parameters=(Parameter("play_m", "m", 0.0, 0.0, 0.01, 0.001),),
            scopes=(Scope.JOINT,),
            physics="The crank runs out of true, and its foot rises and falls once a turn.",
            remedy="Replace the bearing.",
        ),
        worn_crank,
    )
]
