"""Golden rows of what is stored and is no method: a few cheap ones of every kind.

Who changes one of them raises the ``VERSION`` beside the code, and records anew.
"""

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from golden_cases import Case, load_cases

from steadyload.labelling.label_rows import trace_row
from steadyload.learners.features import FeatureKind, features
from steadyload.properties.closed_forms import Stage, fall, tipping_offset
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.runs.verdict_reliability import Sampling
from steadyload.studies.extremes.sweeps import measure_cell
from steadyload.studies.uncertain.cases import SampledMethod, Unit, sample_unit
from steadyload.tuning.proposers import ALGORITHMS
from steadyload.tuning.space import space_on

FILE = Path(__file__).parent / "computations.json"
_TIMES = ("cpu", "nominal_cpu")


def computed() -> dict[str, Any]:
    """All of them by kind, as JSON reads them back."""
    cases = load_cases(planar=False)
    few = sorted(cases[:60], key=lambda case: (len(case.layout), case.layout.name))[:6]
    found = {
        "labels": [trace_row(case.scenario, case.layout) for case in few],
        "features": [_features(case) for case in cases[:3]],
        "extremes": _cell("tower", "mujoco", 240, 3),
        "closed forms": {
            "fall": fall(Stage("mujoco", 240)),
            "tipping": tipping_offset(Stage("mujoco", 240)),
        },
        "certainty": _certainty(cases[1]),
        "properties": dataclasses.asdict(
            search(PROPERTIES["score"], MethodUnderTest("sme"), examples=20, seed=0)
        ),
        "proposals": {name: _proposed(name) for name in ALGORITHMS},
    }
    plain: dict[str, Any] = json.loads(json.dumps(found))
    return plain


def _features(case: Case) -> list[list[float]]:
    return [features(case.layout, kind).sum(axis=0).tolist() for kind in FeatureKind]


def _cell(sweep: str, engine: str, frequency: int, value: float) -> Mapping[str, Any]:
    cell = dataclasses.asdict(measure_cell(sweep, engine, frequency, value))
    return {**cell, "numbers": _timeless(cell["numbers"])}


def _certainty(case: Case) -> Mapping[str, Any]:
    what, sampling = "com=5mm,position=3mm", Sampling(most=128)
    sampled = SampledMethod("equilibrium:time=0.3", what, sampling, 64)
    [row] = sample_unit(Unit(((case.scenario, case.layout),), sampled, {}))
    return _timeless(row)


def _timeless(row: Mapping[str, Any]) -> Mapping[str, Any]:
    return {name: value for name, value in row.items() if name not in _TIMES}


def _proposed(algorithm: str) -> list[list[list[int]]]:
    """Two generations of a small search, told made-up worths."""
    space = space_on("mujoco", "extended")
    proposer = ALGORITHMS[algorithm](space, 4, 0)
    try:
        first = proposer.ask()
        proposer.tell([(0.9 + 0.01 * k, 0.9 + 0.01 * k, 2.0 + k) for k in range(len(first))])
        return [[list(each) for each in asked] for asked in (first, proposer.ask())]
    finally:
        proposer.close()
