"""Engines compared with recorded motion of a real body that is thrown onto a floor."""
