"""The servos one by one: access, backups, settings wanted, readings in words.

Called by ``bigant servo``. Writes to a servo only after a yes.
"""
