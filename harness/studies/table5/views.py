"""Pages that play the cases on which methods differ the most."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from steadyload.app.viewing import write_view
from steadyload.atomic import not_a_link, without_link
from steadyload.layouts.benchmark import load_benchmark
from steadyload.progress import Progress, silent
from steadyload.studies.table5.summary import Table5

FOLDER = "views"


def with_views(
    found: Table5,
    output: Path,
    most: int,
    *,
    progress: Progress = silent,
) -> Table5:
    """The same page, with links to views of the cases to watch.

    Args:
        found: the page.
        output: its folder; views go to :data:`FOLDER` in it, half a megabyte each.
        most: largest number of views.
        progress: called with views done and views in all.

    Raises:
        BenchmarkError: the labelled set cannot be read any more.
        as :func:`steadyload.app.viewing.write_view`.
    """
    own = found.spatial
    watched = list(own.watched)
    count = min(most, len(watched))
    progress(0, count)
    for k, case in enumerate(watched[:count]):
        layout = load_benchmark(case.directory or None).layout(case.layout, case.scenario)
        view = f"{FOLDER}/{case.name}.html"
        not_a_link(output / FOLDER).mkdir(parents=True, exist_ok=True)
        write_view(layout, [case.wrong.spec, case.right.spec], without_link(output / view))
        watched[k] = dataclasses.replace(case, view=view)
        progress(k + 1, count)
    return dataclasses.replace(found, spatial=dataclasses.replace(own, watched=tuple(watched)))
