"""Contact forces of loads at rest, and the loads that boxes bear."""
