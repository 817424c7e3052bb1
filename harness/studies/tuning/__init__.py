"""Tuned parameter sets on cases that no search saw."""
