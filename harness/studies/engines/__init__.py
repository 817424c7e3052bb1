"""Engines against each other: agreement, options, cost."""
