"""A log as figures, numbers and pages.

Called by commands once a run is over. Reads logs, never devices.
"""
