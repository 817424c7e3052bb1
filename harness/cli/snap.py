"""Flags of commands that read layouts: which vertical gaps are closed."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.studies.options import option, positive_number


@dataclass(frozen=True, kw_only=True)
class Snap:
    """Whether small vertical gaps are closed, and which are small."""

    snap: bool = option(False, "close small vertical gaps when reading (default: off)")
    snap_gap: float | None = option(
        None, "close gaps up to this; implies --snap (default: 0.5)", metavar="CM",
        read=positive_number,
    )  # fmt: skip

    @property
    def gap(self) -> float:
        """Gaps up to this [cm] are closed."""
        from steadyload.layouts.snapping import SNAP_GAP

        return self.snap_gap or (SNAP_GAP if self.snap else 0.0)
