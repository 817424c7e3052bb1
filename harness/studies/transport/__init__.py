"""The largest acceleration that complete loads hold, by method, beside the reference's."""
