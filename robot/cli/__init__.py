"""The command line: the path is the command (``cli/servo/zero.py`` is ``bigant servo zero``).

A module adds its arguments and runs its command; only the one asked for is imported. Nothing imports this
package.
"""
