"""Bringing a robot up by hand, before it walks: servos, force sensors, the pre-flight list.

Called by the commands of ``servo``, ``ft``, ``check`` and ``doctor``. Knows no gait and no diagnosis.
"""
