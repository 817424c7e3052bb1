"""The search for the nearest plan that stands."""
