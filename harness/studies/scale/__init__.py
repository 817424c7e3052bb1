"""Time and memory of a study by its number of rows."""
