"""The table of a run without its times, by which runs are compared."""

from steadyload.runs.results import load_results


def verdicts(directory):
    frame = load_results(directory)
    return frame.drop(columns=[c for c in frame if c.startswith(("cpu_", "wall_"))])
