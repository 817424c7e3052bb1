"""A cascade on cases that nothing was fitted on, beside its stages and other methods."""
