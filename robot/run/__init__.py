"""The shell around the step, the only package that waits: loop, rig, real ports, operator, run header.

Called by ``bigant drive``, replays and bring-up. Decides nothing that the step decides.
"""
