"""Trials against the simulator: the study and its evidence, and what they show before a cause is named.

Is there a gap, where does it lie, what changes in the course of a run, how far do causes shrink it. Called
by every step of a diagnosis, and by what measures a diagnosis again; calls none of them.
"""
