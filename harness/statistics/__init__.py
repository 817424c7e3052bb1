"""Numbers with intervals: estimates, metrics, paired tests, reliability of probabilities."""
