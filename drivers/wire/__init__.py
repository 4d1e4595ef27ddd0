"""The bytes of both devices as they pass: recorded below the drivers, and put in words.

Called where a run records bytes or compares them. Changes nothing that passes.
"""
