"""Loading in a physics engine: scenes, steps, criteria of movement."""
