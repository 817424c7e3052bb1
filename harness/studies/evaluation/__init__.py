"""The paper's Table 5 for every engine: all methods on the labelled test split, and their cost."""
