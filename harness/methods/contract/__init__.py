"""The contract of methods: name and parameters, judgement, verdict, times."""
