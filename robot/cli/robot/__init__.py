"""Commands ``bigant robot``: the robot file. Arguments here, work below."""
