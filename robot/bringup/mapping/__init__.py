"""Which servo and which transducer is on which leg, and how mounted: one leg turned, one foot pressed.

Called by ``bigant servo jog``, ``bigant ft identify`` and the first day. What moves goes through the gate.
"""
