"""Methods by statics: exact equilibrium, and settling."""
