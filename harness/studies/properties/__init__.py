"""Properties asked of methods and engines, over processes."""
