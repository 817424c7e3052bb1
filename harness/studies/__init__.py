"""How judges are compared: methods x layouts -> results -> what a report shows."""
