"""Simulations of only what a step changes, compared with those of the whole pile."""
