"""Plans of trainings: what is trained on which sets, read from a file and made."""
