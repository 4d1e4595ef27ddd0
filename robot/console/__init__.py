"""How every command talks: exit codes, progress, numbers, tables, JSON, what fits a terminal.

Called by every package above. Knows nothing of robots.
"""
