"""What a study needs by its number of rows: time, memory and size of its folder."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScaleStep:
    """What one process needed for a step: wall and CPU time [s], the most memory [MiB]."""

    wall: float
    cpu: float
    peak: float


@dataclass(frozen=True, slots=True)
class ScalePoint:
    """What a study of so many rows needs; ``size`` of its folder [MiB].

    ``run`` is the process that coordinates and writes, ``load`` reads all columns of all rows,
    ``report`` makes what a page shows.
    """

    rows: int
    layouts: int
    size: float
    run: ScaleStep
    load: ScaleStep
    report: ScaleStep
