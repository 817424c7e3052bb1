"""The checks behind :mod:`steadyload.engines.conformance`."""
