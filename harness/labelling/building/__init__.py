"""What labelled sets are made of: layouts that are packed or read, their cases and splits."""
