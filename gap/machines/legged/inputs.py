"""What was measured in a trial, on the working grid: the inputs of the stages."""

from dataclasses import dataclass

import numpy as np

from model.effects.grid import Grid, make_grid, place
from model.effects.signals import SensorSignals
from model.errors import GapError
from model.values.arrays import FloatArray, readonly
from model.values.machine_names import MachineNames
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True, eq=False)
class LeggedInputs(SensorSignals):
    """What the sensors did read, W frames of N legs; NaN where nothing was measured. Commands: (W, N)."""

    grid: Grid
    trial: Trial
    command_rad: FloatArray

    def delayed_command(self, delay_s: float) -> FloatArray:
        """Commands that act later, (W, N): shifted from the trial's own samples."""
        if delay_s == 0.0:
            return self.command_rad
        return place(self.grid, self.trial.time_s, self.trial.command_rad, delay_s)

    @property
    def start_pose(self) -> FloatArray:
        """Measured x, y, yaw at the beginning, (3,); the origin if there is none."""
        start = np.array([*self.body_m[0, :2], self.body_rad[0, 2]])
        return np.where(np.isfinite(start), start, 0.0)


def make_inputs(trial: Trial, names: MachineNames) -> LeggedInputs:
    """Put a trial on the grid.

    Raises:
        GapError: It is another robot's, or too short.
    """
    if trial.header.names != names:
        raise GapError(
            f"the trial has legs {', '.join(trial.joints)}, the simulator {', '.join(names.joints)}; "
            "name the robot file that it was made with"
        )
    grid = make_grid(trial.time_s)

    def on_grid(values: FloatArray) -> FloatArray:
        placed: FloatArray = readonly(place(grid, trial.time_s, values))
        return placed

    angles = trial.body_angles_rad.copy()
    known = np.isfinite(angles[:, 2])
    angles[known, 2] = np.unwrap(angles[known, 2])
    return LeggedInputs(
        time_s=grid.time_s,
        grid=grid,
        trial=trial,
        command_rad=on_grid(trial.command_rad),
        shaft_rad=on_grid(trial.shaft_rad),
        foot_m=on_grid(trial.foot_m),
        force_n=on_grid(trial.force_n),
        body_m=on_grid(trial.body_position_m),
        body_rad=on_grid(angles),
    )
