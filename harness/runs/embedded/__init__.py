"""The study that comes with the package, on a slice of the shipped labelled set."""
