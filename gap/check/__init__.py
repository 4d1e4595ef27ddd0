"""Diagnoses against known causes: how often right, how surely, how far the gap shrank.

Called by ``bigant campaign score``. Judges answers and never takes part in making them.
"""
