"""What learned judges are worth: a plan of trainings, made one after the other, and judged."""
