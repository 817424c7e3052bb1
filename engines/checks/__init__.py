"""The checks behind :mod:`engines.conformance`."""
