"""Where virtual devices live: one robot in memory, a process of its own, or recorded bytes.

Called by ``robot.virtual`` and ``bigant sim serve``. Puts the other rooms together.
"""
