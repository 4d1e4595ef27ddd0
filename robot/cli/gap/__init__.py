"""Commands ``bigant gap``: where a simulator differs from measured runs. Arguments here, work below."""
