"""The values that travel through the program, one frozen dataclass per stage.

Shapes use N for the number of legs, in the leg order of the robot file (BigANT: HL, ML, FL, HR, MR, FR).
Arrays are float64 (counts int64, flags bool) and read-only. What is absent is NaN with ``valid=False``,
never 0. Times ``t_ns`` are integer nanoseconds of one monotonic clock. B is the body frame (x forward, y
left, z up, origin at the centre of mass), W the world. Every package may import this one; it imports
numpy only.
"""
