"""The topic that distinguishes our logs from other bags."""

# Each message is one whole tick.
TICK_TOPIC = "/bigant/tick"
