"""Learned judges: methods that were trained on labelled layouts. None is here yet."""
