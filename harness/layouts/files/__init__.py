"""Layout files: their columns, dialects, records and limits."""
