"""Engines at the edge of numerical stability."""
