"""The same controller on virtual hardware: in memory, in a process of its own, as a twin.

Called by ``drive``, ``sim`` and campaigns. The only package below ``cli`` that puts controller and plant
together.
"""
