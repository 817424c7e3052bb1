"""The checks behind :mod:`steadyload.engines.checks.conformance`."""
