"""Which servo and which transducer is on which leg, and how mounted: one leg turned, one foot pressed.

Called by ``bigant servo jog``, ``bigant force identify`` and the first day. Every motion passes the gate.
"""
