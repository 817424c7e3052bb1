"""Golden ends of released bodies: ten measured tosses, in every engine that takes one in flight."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import moved_starts
import numpy as np
from verdicts import SEEDS, machine

from steadyload.engines.attitudes import degrees_apart
from steadyload.engines.registry import package_versions
from steadyload.measured.profiles import motion_profile
from steadyload.methods.registry import make_method
from steadyload.studies.reality.releasing import Taken, end_of
from steadyload.studies.reality.running import able_engines

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "tosses" / "tosses.parquet"
"""Beside the project, which keeps no data of others."""
PROFILE = ROOT / "docs" / "measured" / "tosses.toml"
FILE = Path(__file__).parent / "verdicts" / "tosses.json"

COUNT, EVERY = 10, 28
"""Of 285 tosses."""

FLIGHT = Taken(offset=(0.0, 0.0, 0.005))
"""Near to what flights show: worlds with the centre of mass in the middle are a special case."""

STEADY_MM, STEADY_DEG = 0.1, 0.05
"""What ends nearer than this from moved starts holds on any kind of machine ..."""

CLOSE_MM, CLOSE_DEG = 1.0, 0.5
"""... to within this."""

End = Mapping[str, Any]


def spec_on(engine: str) -> str:
    """The contact that the authors of the data identified."""
    values = "friction=0.18,frequency=480,restitution=0.125,emulate=restitution"
    return str(make_method(f"simulation@{engine}:{values}").spec)


def ends(engine: str) -> list[End]:
    """Where ten tosses come to rest in an engine, in turn; nulls where it fails."""
    trials = motion_profile(PROFILE).read(DATA)[::EVERY][:COUNT]
    return [_end(trial, engine) for trial in trials]


def _end(trial: Any, engine: str) -> End:
    record = FLIGHT.record(trial)
    found = end_of(record, FLIGHT.box(record, FLIGHT.release(record)), spec_on(engine))
    centre, attitude = (None, None) if found is None else (part.tolist() for part in found)
    return {"toss": trial.name, "centre": centre, "attitude": attitude}


def recorded() -> Mapping[str, Any]:
    """Ends by engine, each with whether it holds on any kind of machine, and what made them."""
    return {"machine": machine(), "engines": {name: _recorded(name) for name in able_engines()}}


def _recorded(engine: str) -> Mapping[str, Any]:
    kept, from_moved = ends(engine), []
    for seed in SEEDS:
        with moved_starts.by(seed):
            from_moved.append(ends(engine))
    found = [
        {**end, "steady": all(near(end, each[k], STEADY_MM, STEADY_DEG) for each in from_moved)}
        for k, end in enumerate(kept)
    ]
    return {"packages": packages(engine), "ends": found}


def packages(engine: str) -> dict[str, str]:
    """Versions of what an engine computes with."""
    return package_versions(sorted(make_method(spec_on(engine)).numerics()))


def near(one: End, other: End, most_mm: float, most_deg: float) -> bool:
    """Whether two ends of a toss are the same to within a distance and an angle."""
    if one["centre"] is None or other["centre"] is None:
        return one["centre"] is other["centre"]
    off_mm = 1e3 * float(np.linalg.norm(np.subtract(one["centre"], other["centre"])))
    return off_mm <= most_mm and degrees_apart(one["attitude"], other["attitude"]) <= most_deg


def differences(kept: Sequence[End], now: Sequence[End], *, same_machine: bool) -> list[str]:
    """A sentence for every toss that ends elsewhere now.

    Args:
        kept: ends, each with whether it is steady.
        now: of the same tosses in the same order.
        same_machine: of the kind that the kept ones are of: ends are equal to the last bit.
            Elsewhere only steady ones count, to within :data:`CLOSE_MM` and :data:`CLOSE_DEG`.
    """
    found = []
    for was, end in zip(kept, now, strict=True):
        assert was["toss"] == end["toss"]
        if same_machine:
            is_same = was["centre"] == end["centre"] and was["attitude"] == end["attitude"]
        else:
            is_same = not was["steady"] or near(was, end, CLOSE_MM, CLOSE_DEG)
        if not is_same:
            found.append(f"toss {was['toss']}: {was['centre']} -> {end['centre']}")
    return found


def read() -> Mapping[str, Any]:
    """What :func:`recorded` kept."""
    kept: Mapping[str, Any] = json.loads(FILE.read_text())
    return kept
