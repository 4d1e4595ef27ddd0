"""Commands ``bigant log``: logs. Arguments here, work below."""
