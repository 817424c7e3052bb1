"""Fitting a cascade: what each method says of single steps, what counts as sure, what it costs."""
