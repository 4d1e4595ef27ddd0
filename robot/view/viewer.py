"""What draws ticks in somebody else's program; each comes with a package of its own, imported late."""

from abc import ABC, abstractmethod

from model.values.parameters import RobotParameters
from model.values.tick import Tick
from robot.view.frames import FrameTracker
from robot.view.numbers import NewsTracker

TRAJECTORY_PERIOD_NS = 500_000_000


class Viewer(ABC):
    """Takes every tick and draws some of them.

    Args:
        parameters: Dimensions of the robot.

    Attributes:
        port: Port of its server, 0 without one.
    """

    port = 0

    def __init__(self, parameters: RobotParameters) -> None:
        self.parameters = parameters
        self.names = parameters.names
        self.frames = FrameTracker()
        self.news = NewsTracker()
        self._next_trajectory_ns = 0

    def trajectory_due(self, unix_ns: int) -> bool:
        """Whether it is time to draw the trajectories again, which are long."""
        due = unix_ns >= self._next_trajectory_ns
        if due:
            self._next_trajectory_ns = unix_ns + TRAJECTORY_PERIOD_NS
        return due

    @property
    def watched(self) -> bool:
        """Whether somebody looks; a file always asks for more."""
        return True

    @abstractmethod
    def note(self, tick: Tick, unix_ns: int) -> None:
        """Write what is new in a tick: changes of mode and health, and faults. Called for every tick."""

    @abstractmethod
    def show(self, tick: Tick, unix_ns: int) -> None:
        """Draw frames, scene and numbers of a tick."""

    @abstractmethod
    def close(self) -> None:
        """Finish the file, stop the server."""
