"""Methods in turn, the cheapest first, and the thresholds between them."""
