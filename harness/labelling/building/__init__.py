"""Making labelled sets: layouts that are packed or read, their cases, and splits."""
