"""Loading sessions: the cost of a placement, and what packing gains."""
