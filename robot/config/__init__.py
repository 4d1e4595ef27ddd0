"""The robot file and the files it names: read once into frozen dataclasses, edited in place.

Called by everybody above. Opens no device.
"""
