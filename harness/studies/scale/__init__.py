"""What a study needs by its number of rows: time and memory."""
