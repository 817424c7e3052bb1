"""The reference simulator compared with itself under finer numerics, and with other engines."""
