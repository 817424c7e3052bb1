"""Cost of single precision in verdicts, told apart from the cost of a contact model."""
