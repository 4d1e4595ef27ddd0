"""Names of the paper's two gaits, which the study of it and the robot file's defaults know by name."""

TRIPOD, METACHRONAL = "tripod", "metachronal"
