"""Commands ``bigant ft``: the force-torque sensors. Arguments here, work below."""
