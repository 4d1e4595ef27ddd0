"""Bringing a robot up by hand: servos, force sensors, what is where, the pre-flight list, the first day.

Called by the commands of ``servo``, ``ft``, ``check``, ``doctor`` and ``bringup``. Knows no diagnosis.
"""
