"""The reliability of verdicts when the loading deviates from its plan."""
