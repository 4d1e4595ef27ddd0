"""Robots that are different from the usual twin: other servo loops, contacts, legs, sensors, days.

Called by campaigns. Composes plant and sensors, and knows nothing of the model's laws or the diagnosis.
"""
