"""The page that plays a loading: markup, style and two scripts."""
