"""Commands ``bigant sim``: virtual hardware. Arguments here, work below."""
