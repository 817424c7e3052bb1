"""The study that comes with the package: its definition, its layouts, and how they were made."""
