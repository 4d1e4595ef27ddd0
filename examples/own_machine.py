"""A machine of a lab's own under diagnosis: a joint pulled by a tendon, with two effects.

python examples/own_machine.py
bigant gap diagnose TRIAL... --machine examples/own_machine.py:make
"""

import numpy as np

from gap.data.check import check_trial
from gap.data.even_grid import even_trial
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import (
    Cause,
    Channel,
    Drive,
    Effect,
    Observation,
    Parameter,
    Scope,
    check_causes,
)
from model.motion.filters import lagged, play
from record.trial.header import TrialHeader
from record.trial.table_file import TableColumn
from record.trial.trial import build_trial

LAG_S = 0.04  # of the nominal drive
EFFECTS = (
    Effect(
        "tendon_stretch", "tendon", (Parameter("rad_per_nm", "rad/(N m)", 0.0, 0.0, 0.5, 0.05),),
        (Scope.JOINT,), "The tendon gives under the joint's torque.", "Fit a thicker tendon.",
    ),
    Effect(
        "slack", "drum", (Parameter("width_rad", "rad", 0.0, 0.0, 0.4, 0.03),),
        (Scope.JOINT,), "The tendon goes slack when the drum turns back.", "Tighten it.",
    ),
)  # fmt: skip


class TendonJoints:
    """Implements ``gap.interfaces.Simulator``; columns command_J_rad, shaft_J_rad and torque_J_nm."""

    name, stages, bodies, effects = "tendon", ("drum", "tendon"), (), EFFECTS

    def __init__(self, joints):
        self.joints = joints
        self.channels = tuple(Channel("shaft_error", joint, "tendon", "rad") for joint in joints)

    def observe(self, trial):
        """What was measured, on the channels and on even frames."""
        even = even_trial(trial)
        values = even.shaft_rad - even.command_rad
        noise = np.full(values.shape, 0.001)
        cycle = np.full(len(values), np.nan)
        return Observation(even.time_s, cycle, values, noise, np.ones(values.shape))

    def predict(self, trial, causes, drive):
        """What the channels would read; one stage feeds the other, so both drives are the same."""
        check_causes(causes, self)
        even = even_trial(trial)
        predicted = []
        for at, joint in enumerate(self.joints):
            own = {c.effect: c.values[0] for c in causes if joint in c.joints}
            drum = play(even.command_rad[:, at], own.get("slack", 0.0), even.command_rad[0, at])
            shaft = lagged(drum, LAG_S, even.period_s)
            shaft = shaft - own.get("tendon_stretch", 0.0) * even.torque_nm[:, at]
            predicted.append(shaft - even.command_rad[:, at])
        return np.column_stack(predicted)

    def check(self, trial):
        """Faults of the data that any trial may have."""
        return check_trial(trial)


def make(trials):
    """The machine of trials that name one machine's file (here: none)."""
    return TendonJoints(trials[0].joints)


def made_up_trial(stretch, seed=0):
    """A run of a finger whose tendon gives, with the noise of its encoder."""
    t = np.arange(1500) / 50
    command, torque = np.sin(0.9 * t) + 0.3 * np.sin(4 * t), 0.5 + np.cos(0.9 * t)
    header = TrialHeader("tendon", ("finger",))
    columns = {"time_s": t, "command_finger_rad": command, "torque_finger_nm": torque}
    trial = build_trial(header, [TableColumn(*one) for one in columns.items()])
    error = make([trial]).predict(
        trial, [Cause("tendon_stretch", ("finger",), (stretch,))], Drive.COMMAND
    )
    noise = np.random.default_rng(seed).normal(0, 0.001, len(t))
    columns["shaft_finger_rad"] = command + error[:, 0] + noise
    return build_trial(header, [TableColumn(*one) for one in columns.items()])


if __name__ == "__main__":
    run = made_up_trial(stretch=0.06)
    print(diagnose([run], make([run])).sentence)
