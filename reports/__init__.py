"""The only place that formats or draws: small typed records in, Markdown and pictures out."""

if __name__ != "steadyload.reports":
    raise ImportError("reports is installed as steadyload.reports: import it under that name")
