"""The only place that formats or draws: small typed records in, Markdown and pictures out."""
