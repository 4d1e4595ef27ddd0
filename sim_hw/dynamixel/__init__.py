"""Virtual servos: control table, firmware, protection, and the ports they answer on.

Called by ``sim_hw.host``. Knows the world behind the shafts by an interface only.
"""
