"""Gaits: shaft angle and speed of every leg at any time. Pure functions of time."""
