"""Records of time, memory and size of the folder of a study by its number of rows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScaleStep:
    """Needs of one process for a step: wall and CPU time [s], peak memory [MiB]."""

    wall: float
    cpu: float
    peak: float


@dataclass(frozen=True, slots=True)
class ScalePoint:
    """Needs of a study with a number of rows; ``size`` of its folder [MiB].

    ``run`` is the process that coordinates and writes, ``load`` reads all columns of all rows,
    ``report`` computes the records of a page.
    """

    rows: int
    layouts: int
    size: float
    run: ScaleStep
    load: ScaleStep
    report: ScaleStep
