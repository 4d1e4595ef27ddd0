"""A constant of the diagnosis, and the usual ways in which one was chosen."""


class Constant(float):
    """A number with its meaning and how it was chosen; a count is used as ``int(HARMONICS)``."""

    meaning: str
    chosen: str

    def __new__(cls, value: float, meaning: str, chosen: str) -> "Constant":
        """Make one; it is used as the number that it is."""
        made = super().__new__(cls, value)
        made.meaning, made.chosen = meaning, chosen
        return made

    def __reduce__(self) -> tuple[type["Constant"], tuple[float, str, str]]:
        """Travel to other processes as what it is made of."""
        return Constant, (float(self), self.meaning, self.chosen)


THEORY, BY_HAND, DEVELOPMENT = (
    "a convention", "by hand, before any campaign", "on development campaigns of the twin"
)  # fmt: skip
BY_HAND_LATER = "by hand; no figure was compared"
