"""Is this robot fit to walk, and this computer fit to drive it? Facts first, then judgement.

Called by ``bigant check`` and ``bigant devices``. Asks devices in one place and judges apart from them.
"""
