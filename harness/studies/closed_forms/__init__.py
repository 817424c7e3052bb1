"""Engines compared with mechanics: single bodies and small stacks whose motion is known."""
