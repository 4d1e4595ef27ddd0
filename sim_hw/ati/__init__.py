"""The virtual force-torque unit: commands, records, console, in memory or on sockets.

Called by ``sim_hw.host``. Knows forces as numbers, not where they come from.
"""
