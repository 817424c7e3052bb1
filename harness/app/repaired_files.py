"""Files of layouts in which the plans that fail are replaced by their repairs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

from steadyload.app.repair_results import Outcome, Repair
from steadyload.escaping import shown
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import Reading
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.rewriting import Replanned, rewrite


def write_repaired(
    source: Content, target: Path, found: Sequence[Repair], **reading: Unpack[Reading]
) -> None:
    """Write a file again, with the plans that were repaired as they are now.

    All others stay as they are, those among them that are not valid. What is written has been read
    back, and every plan in it is the one that was judged.

    Args:
        source: the content that the plans were read from.
        target: the file that is written, whole or not at all.
        found: the outcomes for all its plans.
        reading: with which the plans were read, see :class:`steadyload.layouts.formats.Reading`.

    Raises:
        LayoutError: the source is no content, or its form cannot state a plan.
        OSError: the file cannot be written.
    """
    if not isinstance(source, Content):
        raise LayoutError(
            f"{shown(source)} is no content of a file; allowed: Content.of(path), from which the "
            "plans were read"
        )
    changed = {
        one.name: Replanned(one.layout, one.origins)
        for one in found
        if one.outcome is Outcome.REPAIRED and one.layout is not None
    }
    rewrite(source, target, changed, **reading)
