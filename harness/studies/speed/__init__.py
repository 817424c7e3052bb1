"""Cost of judgements: one by one, in batches, in sessions, and by number of items."""
