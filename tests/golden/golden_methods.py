"""What golden verdicts are of: every preset on every engine, and a pairwise array of parameters."""

import json
from typing import NamedTuple

from golden_cases import FILE
from pairwise import Row, pairwise

from steadyload.engines.registry import ENGINES as ENTRIES
from steadyload.engines.registry import capabilities
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method

STATIC = (
    "fbs", "pbs0.5", "pbs0.7", "pbs0.9", "sme",
    "equilibrium", "equilibrium:sides=frictionless", "equilibrium:sides=friction",
    "equilibrium:sides=friction,cones=exact", "equilibrium:time=0.3",
    "lstm_1", "lstm_e",
)  # fmt: skip

PRESETS = ("ps3", "ps5", "ps3-literal", "ps5-literal", "ps_opt", "ps_opt-paper", "label")
ENGINES = ("bullet", "mujoco", "dart", "chipmunk")
OPTIONAL = tuple(
    name for name, entry in ENTRIES.items()
    if entry.optional and not entry.check_only and name != "reference"
)  # fmt: skip
OWN = (
    "cascade@mujoco",
    "label@reference",
    "label@reference:contact=adams",
    "label@reference:tolerance=1e-5,between_steps=carry",
)

LATER = (
    "equilibrium:margin=0.01",
    "lstm_1:question=stands", "lstm_e:question=stands",
    *(f"ps_opt@{engine}:question=stands" for engine in ("bullet", "mujoco", "dart")),
    "cascade@mujoco:question=stands",
    *(f"label@{engine}:frequency=240,scope=moving" for engine in ("bullet", "mujoco")),
    "label@reference:question=stands",
    "settling",
    *(f"{preset}@{engine}" for preset in ("label", "ps_opt") for engine in OPTIONAL),
    *(f"ps_opt@{engine}:question=stands" for engine in OPTIONAL),
)  # fmt: skip
"""Judged after all others, as they were added later."""

QUICK, DEEP = 24, 700
"""Cases of a method at most; the quick test has more of those that need no engine."""
_QUICK_STATIC = 240
_OF_ARRAY = 3
"""Cases that a row of the array judges, others than those of the row before."""

FACTORS = {
    "engine": ENGINES,
    "t_max": ("0.1", "0.3"),
    "frequency": ("60", "240"),
    "between_steps": ("carry", "reseat"),
    "criterion": ("paper", "adams"),
    "samples": ("1", "10"),
    "scope": ("all", "local", "widening"),
    "broad_phase": ("none", "simple", "dbvt", "sweep"),
    "solver_iterations": ("none", "20"),
    "friction": ("0.3", "0.5"),
    "restitution": ("0", "0.2"),
    "linear_damping": ("0", "0.05"),
    "angular_damping": ("0", "0.05"),
    "margin": ("0", "0.003"),
    "shrink": ("0", "0.0005"),
    "jitter": ("0", "0.0001"),
    "rest_speed": ("0", "0.02"),
    "early_exit": ("0", "1.5"),
    "emulate": ("", "restitution"),
    "impedance": ("", "0.95"),
    "impedance_deep": ("", "0.999"),
    "impedance_depth": ("", "0.0005"),
}


class Asked(NamedTuple):
    """A method, and which of the kept cases it judges at most."""

    spec: str
    planar: bool
    cases: range


def asked(*, deep: bool) -> list[Asked]:
    """What is judged, in this order, in one process."""
    specs = [*STATIC, *(f"{preset}@{engine}" for preset in PRESETS for engine in ENGINES), *OWN]
    found = [_asked(spec, deep=deep) for spec in specs]
    if not deep:
        for number, spec in enumerate(json.loads(FILE.read_text())["array"]):
            start = number * _OF_ARRAY % QUICK
            found.append(Asked(spec, _is_planar(spec), range(start, start + _OF_ARRAY)))
    return [*found, *(_asked(spec, deep=deep) for spec in LATER)]


def _asked(spec: str, *, deep: bool) -> Asked:
    quick = QUICK if make_method(spec).spec.engine else _QUICK_STATIC
    return Asked(spec, _is_planar(spec), range(DEEP if deep else quick))


def _is_planar(spec: str) -> bool:
    engine = make_method(spec).spec.engine
    return engine is not None and capabilities(engine).dimensions == 2


def array() -> list[str]:
    """Specs in which any two values of two parameters meet, where they can."""
    return [_spec(row) for row in pairwise(FACTORS, _can_be)]


def _spec(row: Row) -> str:
    values = ",".join(f"{k}={v}" for k, v in row.items() if v and k != "engine")
    return f"simulation@{row['engine']}:{values}"


def _can_be(row: Row) -> bool:
    try:
        make_method(_spec(row))
    except SpecError:
        return False
    return True
