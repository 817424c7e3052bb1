"""Plans of packers: the share that stands while it is loaded, by their labels."""
