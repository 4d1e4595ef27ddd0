"""A log as arrays, a block of ticks at a time: messages of one form are a table, and a field its columns.

``read`` is the way in.
"""
