"""Complete loads on the road: accelerations, rules, and the largest acceleration that is held.

Items are rigid boxes on a deck. There is no wrap, no strap and no anti-slip mat.
"""
