"""Repair of packers' plans that fail, in several ways on the same plans."""
