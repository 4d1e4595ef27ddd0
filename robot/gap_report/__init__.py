"""A diagnosis for people and programs: trials in, lines, pages and JSON out.

Called by ``bigant gap``. Decides nothing; every statement comes from ``gap``.
"""
