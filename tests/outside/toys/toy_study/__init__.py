"""A study of another distribution: one folder."""
