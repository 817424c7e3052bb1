"""Pages: composed of a template and rows, and written as Markdown and HTML."""
