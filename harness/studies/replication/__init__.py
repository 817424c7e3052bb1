"""The paper's experiment as it was run: its files, its splits, and all of its methods on each."""
