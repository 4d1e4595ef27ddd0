"""One robot as it really is: what differs from the nominal one, and how its sensors read.

Called by the host and by campaigns. Knows plant and sensors, nothing of the diagnosis.
"""
