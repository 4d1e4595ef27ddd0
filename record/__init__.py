"""What is written down: logs of runs, trials of any machine, and files that are whole or absent.

Called by everything that keeps or reads data. Knows no device and no control.
"""
