"""Campaigns: many cases drawn, walked by twins, sealed, diagnosed and counted.

Called by ``bigant sim campaign`` and ``bigant gap check``. Opens a seal only to count.
"""
