"""A log as figures, numbers and pages; markup and style of every page in ``templates/``.

Called by commands once a run is over. Reads logs, never devices.
"""
