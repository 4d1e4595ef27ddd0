"""What ``bigant replay`` is asked to do."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class ReplayRequest:
    """The options of ``bigant replay``, under their names; see ``robot.cli.replay``."""

    path: Path
    tolerance: float
    robot: Path | None
    json: bool
    bus: bool
    drive: bool
    hardware: str
    armed: bool
    force_unit: str | None
    virtual_time: bool
    seed: int
    log: Path | None
    out: Path | None
