"""Scripted faults of both devices: what a scenario file may say, and what then happens.

Called by ``sim_hw.host``. Hits bytes and devices from outside; sound devices do not know it.
"""
