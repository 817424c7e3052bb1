"""Files of layouts in which the plans that fail are replaced by their repairs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from steadyload.app.repair_results import Outcome, Repair
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.rewriting import Replanned, rewrite


def write_repaired(
    source: Path,
    target: Path,
    found: Sequence[Repair],
    *,
    kind: Format | None = None,
    dialect: Dialect | None = None,
) -> None:
    """Write a file again, with the plans that were repaired as they are now.

    All others stay as they are, those among them that are not valid.

    Args:
        source: the file that was read.
        target: the file that is written, whole or not at all.
        found: the outcomes for all its plans.
        kind: the format that is written; None for the form of the source. In another one there is
            no place for plans that are not valid.
        dialect: with which the source was read, as of :func:`steadyload.layouts.formats.Reading`.

    Raises:
        LayoutError: the form of the source, or the format, cannot state a plan.
        OSError: a file cannot be read or written.
    """
    if kind is not None:
        write_layouts(target, [one.layout for one in found if one.layout is not None], kind)
        return
    changed = {
        one.name: Replanned(one.layout, one.origins)
        for one in found
        if one.outcome is Outcome.REPAIRED and one.layout is not None
    }
    rewrite(source, target, changed, dialect=dialect)
