"""The reference simulator against itself under finer numerics, and against other engines."""
