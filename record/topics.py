"""The topic by which a log of ours is distinguished from any other bag."""

# Each message is one whole tick.
TICK_TOPIC = "/bigant/tick"
