"""Engines at the limits of numerical stability."""
