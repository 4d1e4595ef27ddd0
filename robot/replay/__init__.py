"""A recorded run again: through the step, through the drivers, or on a robot; and the differences.

Called by ``bigant replay`` and by tests through the pytest plugin. Never judges what it did not compare.
"""
