"""The log: every tick to an MCAP file with ROS 2 schemas, and back, also from damaged files.

Called by the loop's recorder and by every command that reads a log. Knows values, not how they came about.
"""
