"""Rules on what lies below an item, without forces."""
