"""The page that plays a loading in 3-D."""
