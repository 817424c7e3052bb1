"""Rankings of methods over the rule by which labels are made."""
