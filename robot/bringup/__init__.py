"""Bringing a robot up by hand: servos, force sensors, the pre-flight list.

Called by ``servo``, ``ft``, ``check``, ``doctor`` and ``devices``. Moves nothing by itself.
"""
