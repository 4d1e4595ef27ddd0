"""Campaigns: many cases drawn, walked by twins, sealed, diagnosed and counted.

Called by ``bigant campaign make`` and ``bigant campaign score``. Opens a seal only to count.
"""
