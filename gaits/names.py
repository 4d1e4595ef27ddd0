"""Names of the gaits, for who must not wait for their mathematics: parsers of commands."""

TRIPOD, METACHRONAL = "tripod", "metachronal"
GAIT_NAMES = (TRIPOD, METACHRONAL)
