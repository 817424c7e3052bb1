"""Published verdicts and labels, judged again on the machine at hand."""
