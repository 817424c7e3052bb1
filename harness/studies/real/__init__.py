"""Accuracy and cost of all methods on layouts of real size, by number of boxes."""
