"""Where a simulator differs from measured runs, which effect causes it, and how far it shrinks.

Here: what engine and machines know of each other. Machines are plug-ins in ``gap.machines``; the engine
stands in ``data``, ``residuals``, ``search``, ``experiments``, ``diagnosis``, and never imports a machine.
"""
