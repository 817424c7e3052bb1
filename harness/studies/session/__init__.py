"""Loading sessions: the cost of a placement, and their gain for packing."""
