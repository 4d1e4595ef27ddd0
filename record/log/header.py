"""A run as a whole in a log's metadata: one value, whoever writes the log."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from record.log.versions import software, software_versions


@dataclass(frozen=True, slots=True, kw_only=True)
class RunHeader:
    """A run in a few words. In the log's metadata each field stands under its own name, as text.

    Attributes:
        robot: Name of the robot.
        hardware: ``virtual``, the serial port of the servo bus, or ``imported``.
        time: ``virtual`` or ``real``; empty where no loop of ours ran.
        gait: Gait that it began with.
        frequency_hz: Its frequency; None or NaN where it is not known.
        steer: -1 (right) to 1 (left), None where it is not known.
        seed: Seed of virtual noise, None without any.
        scenario: File of the faults of virtual hardware, empty for none.
        trial: Header of the trial that the log was made from, empty for none.
    """

    robot: str
    hardware: str
    time: str = ""
    gait: str = ""
    frequency_hz: float | None = None
    steer: float | None = None
    seed: int | None = None
    scenario: str = ""
    trial: str = ""

    def metadata(self) -> Mapping[str, str]:
        """Return the texts, without those that say nothing; with the versions of all software."""
        texts = {
            "robot": self.robot,
            "hardware": self.hardware,
            "time": self.time,
            "gait": self.gait,
            "frequency_hz": _text(self.frequency_hz),
            "steer": _text(self.steer),
            "seed": "" if self.seed is None else str(self.seed),
            "scenario": self.scenario,
            "trial": self.trial,
        }
        known = {key: text for key, text in texts.items() if text}
        return {**known, "software": software(), **software_versions()}


def _text(value: float | None) -> str:
    return "" if value is None or math.isnan(value) else f"{value:g}"
