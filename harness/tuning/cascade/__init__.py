"""Fitting of a cascade: step scores of its methods, their thresholds, and its cost."""
