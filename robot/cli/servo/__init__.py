"""Commands ``bigant servo``: the servos one by one. Arguments here, work below."""
