"""The first day with a real robot, hung in a frame: thirteen numbered steps, resumable, on one page.

Called by ``bigant bringup``; the tests marked ``hitl`` run the same steps. Each step says what it will do,
asks, keeps the raw bytes, judges; what it settles about the devices becomes a scenario file.
"""
