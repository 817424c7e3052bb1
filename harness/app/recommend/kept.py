"""Measurements that are kept in a file: those of the package, and those of a work folder."""

from __future__ import annotations

import dataclasses
from bisect import bisect_left
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from steadyload.app.recommend.front import Front, FrontError
from steadyload.atomic import manifest_text, verified_manifest, write_atomically
from steadyload.config import bind
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import FINE_SIZES
from steadyload.reading import MAX_STORED_BYTES, TooLargeError, content_of, json_of, own_file

SPATIAL = "spatial"
"""The folder in the work folder that holds the rows of 3-D methods."""

REAL, SMALL = "real", "small"
"""Those of judgements with a time limit: of the set, and of small layouts."""

NAME = "fronts.json"
"""The file in a work folder that holds its fronts, where there was a timing pass."""

FILE = own_file("steadyload.app.recommend", NAME)
"""The measurements that come with the package."""


def load_fronts(file: Path = FILE) -> tuple[Front, ...]:
    """The measurements of a file.

    Raises:
        FrontError: the file is missing or damaged.
        TooLargeError: it has too many bytes.
    """
    try:
        content = verified_manifest(json_of(content_of(file, MAX_STORED_BYTES)))
        return tuple(map(_read, content["fronts"]))
    except TooLargeError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise FrontError(
            f"{file}: holds no measured methods; name the folder of a study on a labelled set: "
            "steadyload recommend --from RUN"
        ) from None


def _read(entry: Mapping[str, Any]) -> Front:
    found = bind(Front, entry, "front")
    if "machine" not in found.about:
        raise KeyError
    return found


def write_fronts(fronts: Iterable[Front], file: Path) -> Path:
    """Write measurements in the place of those that a file holds; returns the file."""
    write_atomically(file, manifest_text({"fronts": [dataclasses.asdict(f) for f in fronts]}))
    return file


def merged(kept: Iterable[Front], new: Iterable[Front]) -> tuple[Front, ...]:
    """Fronts that are kept, and new ones in the place of those of the same cases.

    Same cases are those of one part, question and bin of the number of boxes. A front that another
    study measured on more of them stays.
    """
    found = {_cases(front): front for front in kept}
    for front in new:
        before = found.get(_cases(front), front)
        if before.study == front.study or before.cases <= front.cases:
            found[_cases(front)] = front
    return tuple(sorted(found.values(), key=lambda front: (*_cases(front)[:2], front.fewest)))


def _cases(front: Front) -> tuple[str, Question, int]:
    return front.part, front.question, bisect_left(FINE_SIZES, front.most)
