"""The log: every tick to an MCAP file with ROS 2 schemas, and back."""
