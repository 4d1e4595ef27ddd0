"""What runs can show of each effect, and what they cannot, before anything is judged.

Called by ``robot/gap_report`` and ``robot/campaign`` ahead of a diagnosis, by an import for each table, and
by ``gap/diagnosis``. It does not know how causes are fitted, and not what a sensor is called in words.
"""
