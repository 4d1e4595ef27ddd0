"""Machines that can be diagnosed, each a plug-in of the protocol in ``gap.interfaces``.

Called through a trial's machine kind. A machine knows its own physics, never the engine.
"""
