"""The page of a study in a browser: markup, style, tables and charts."""
