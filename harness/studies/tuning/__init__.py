"""Tuned parameter sets on cases that were used in no search."""
