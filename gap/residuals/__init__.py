"""Measured minus predicted: parts of trials, predictions, the baseline, whitened residuals.

Called by search and diagnosis. Knows a simulator by its interface only.
"""
