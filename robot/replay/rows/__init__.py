"""A controller over recorded ticks of a walk, in rows of arrays; ``walker`` is the way in.

What comes out is what its step makes of them one by one, to the bit.
"""
