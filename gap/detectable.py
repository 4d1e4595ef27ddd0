"""What size of a cause would have shown."""

from dataclasses import dataclass

from gap.interfaces import place_words


@dataclass(frozen=True, slots=True)
class Detectable:
    """Smallest size of a parameter that would have shown.

    Attributes:
        size: Distance from neutral, in the parameter's unit; infinite if these runs cannot show it.
        neutral: Value at which nothing happens.
        lower: Smallest value that makes sense.
        upper: Largest value that makes sense.
        joint: Where it would have to be so large: where most hides. Empty for the whole machine.
    """

    effect: str
    parameter: str
    size: float
    unit: str
    neutral: float
    lower: float
    upper: float
    joint: str = ""

    @property
    def place(self) -> str:
        """Its effect, and where."""
        return place_words(self.effect, (self.joint,) if self.joint else ())

    @property
    def of_range(self) -> float:
        """The size as a share of how far from neutral makes sense at most: what is above 1 cannot show."""
        return self.size / max(self.upper - self.neutral, self.neutral - self.lower)

    @property
    def values(self) -> tuple[float, ...]:
        """The values at that distance that make sense, the lower one first; none if it is out of range."""
        both = (self.neutral - self.size, self.neutral + self.size)
        return tuple(value for value in both if self.lower <= value <= self.upper)
