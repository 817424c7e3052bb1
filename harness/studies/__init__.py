"""Studies: methods x layouts -> results -> records of a report."""
