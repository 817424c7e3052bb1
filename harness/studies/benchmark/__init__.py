"""The labelled set: how it is labelled, and its page."""
