"""Runs that a legged robot could make to tell candidates apart: gait, frequency, steering, a weight."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gaits.gait import Gait
from gap.interfaces import Cause, Proposal
from record.trial.header import LEGGED, TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import build_trial

RATE_HZ = 100.0
FACTORS = (0.5, 1.0, 1.5, 2.0, 3.0)  # of the gait's own frequency
SWAY = (0.0, 0.5)
SHORTEST_S, FEWEST_CYCLES = 20.0, 2
WALK_UP_MINUTES, WEIGHT_MINUTES = 0.5, 2.0  # of a person's time besides the walk; assumed
WEIGHT_SHARE = 0.12  # of the robot's mass: well below what the springs of a leg carry
WEIGHT_M = (0.15, 0.15)  # ahead and to the left, on a body of this size; assumed
PLACES = (("the body's middle", 0.0, 0.0), ("its front left", *WEIGHT_M))


@dataclass(frozen=True, slots=True, eq=False)
class LeggedProposer:
    """Makes the proposals of a robot.

    ``limits_hz`` are the highest frequencies of gaits that the servos follow; ``robot_option`` is what the
    command line needs to name the robot file, empty for the default one; ``gait_files`` are the Python
    files of gaits that the robot file does not have.
    """

    legs: tuple[str, ...]
    gaits: Mapping[str, Gait]
    limits_hz: Mapping[str, float]
    mass_kg: float
    robot_text: str
    robot_option: str = ""
    gait_files: Mapping[str, str] = field(default_factory=dict)

    def proposals(self) -> Sequence[Proposal]:
        """Return every gait at several frequencies, straight and turning, and with a weight."""
        proposals = []
        for name, gait in self.gaits.items():
            for factor in FACTORS:
                frequency_hz = float(f"{factor * gait.frequency_hz:.3g}")
                if frequency_hz > self.limits_hz[name]:
                    continue
                proposals += [self._plain(gait, frequency_hz, steer) for steer in SWAY]
            proposals += [self._loaded(gait, *place) for place in PLACES]
        return proposals

    def _plain(self, gait: Gait, frequency_hz: float, steer: float) -> Proposal:
        course = "straight" if steer == 0 else f"steering {steer:g}"
        return self._proposal(
            gait, frequency_hz, steer, f"{gait.name} at {frequency_hz:g} Hz, {course}"
        )

    def _loaded(self, gait: Gait, where: str, x_m: float, y_m: float) -> Proposal:
        mass_kg = round(WEIGHT_SHARE * self.mass_kg, 1)
        at = f" (x {x_m:g}, y {y_m:g} m)" if x_m or y_m else ""
        words = f"{gait.name} at {gait.frequency_hz:g} Hz with {mass_kg:g} kg on {where}{at}"
        known = (Cause("payload", (), (mass_kg, x_m, y_m)),)
        return self._proposal(
            gait, gait.frequency_hz, 0.0, words, known, "weigh it, fasten it, measure its place"
        )

    def _proposal(
        self,
        gait: Gait,
        frequency_hz: float,
        steer: float,
        name: str,
        known: tuple[Cause, ...] = (),
        limits: str = "",
    ) -> Proposal:
        cycles = max(FEWEST_CYCLES, int(np.ceil(SHORTEST_S * frequency_hz - 1e-9)))
        seconds = cycles / frequency_hz
        time_s = np.arange(round(seconds * RATE_HZ) + 1) / RATE_HZ
        angle = gait.motion(gait.start_phase + frequency_hz * time_s, steer).angle_rad
        header = TrialHeader(
            LEGGED, self.legs, gait.name, frequency_hz, RATE_HZ, name, TrialNoise(), "robot.toml",
            self.robot_text,
        )  # fmt: skip
        columns = [
            TableColumn(f"command_{leg}_rad", angle[:, k]) for k, leg in enumerate(self.legs)
        ]
        trial = build_trial(header, (TableColumn("time_s", time_s), *columns))
        named = self.gait_files.get(gait.name, gait.name)
        command = f"bigant drive --gait {named} --frequency-hz {frequency_hz:g} --cycles {cycles}"
        command += f" --steer {steer:g}" if steer else ""
        minutes = seconds / 60 + (WEIGHT_MINUTES if known else WALK_UP_MINUTES)
        return Proposal(name, trial, minutes, limits, known, command + self.robot_option)
