"""How an MCAP file is divided: the index at its end, and the records in its chunks.

Called by what reads logs (``salvage``, ``stretches``). Knows nothing of what the messages say.
"""
