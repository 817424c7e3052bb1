"""A cascade compared with its stages and other methods, on cases on which nothing was fitted."""
