"""The parts whose versions a verdict is kept with."""

import pytest

from steadyload.methods.registry import make_method

SIMULATION = {"contacts", "engine", "loading", "method", "scene", "world"}
RULE = {"contacts", "core", "method"}
EXACT = RULE | {"balance", "motion"}
LEARNED = {"core", "features", "inference", "method"}


@pytest.mark.parametrize(
    ("spec", "parts"),
    [
        ("fbs", RULE), ("sme", RULE), ("equilibrium", EXACT),
        ("equilibrium:margin=1", EXACT | {"drawn in"}), ("equilibrium:time=0.3", EXACT),
        ("settling", RULE | {"balance", "rest position"}),
        ("lstm_1", LEARNED), ("lstm_e", LEARNED),
        *((f"{preset}@{engine}", SIMULATION) for preset in ("ps3", "ps_opt", "label")
          for engine in ("bullet", "mujoco", "dart", "chipmunk")),
        ("label@reference", SIMULATION), ("label@mujoco:scope=moving", SIMULATION | {"moving"}),
        ("cascade@mujoco", {"method"}
            | {f"{part} of ps_opt@mujoco" for part in SIMULATION}
            | {f"{part} of equilibrium:time=0.3" for part in EXACT}
            | {f"{part} of lstm_1" for part in LEARNED}),
    ],
)  # fmt: skip
def test_a_verdict_is_kept_with_the_versions_of_all_that_it_rests_on(spec, parts):
    """A part that is left out would leave verdicts as they are when that part changes."""
    assert make_method(spec).parts().keys() == parts
