"""The estimator over many ticks that are all known, such as those of a log: the usual ones without objects.

What comes out is what ``model.estimator.filter`` makes of the ticks one by one, to the bit.
"""
