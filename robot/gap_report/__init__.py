"""A diagnosis for people and programs: trials in, lines, pages and JSON out.

Called by ``bigant gap``. Decides nothing; what is said comes from ``gap``.
"""
