"""Comparison of engines with each other: agreement, options, cost."""
