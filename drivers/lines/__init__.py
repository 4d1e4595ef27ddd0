"""Sensors that print lines of text, over UDP or a serial port: absolute poses, an IMU.

The loop asks them once a tick and never waits. They know nothing of what becomes of their readings.
"""
