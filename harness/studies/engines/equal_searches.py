"""Parameters found by searches that differ in their engine alone, on cases that none of them saw.

The presets ``ps_opt`` are the best that is known on each engine: they come of searches on different
cases and of different lengths. Engines are compared by ``ps_opt-equal``.
"""

from __future__ import annotations

from typing import Any

import pandas as pd

from steadyload.methods.tuned import EQUAL, TUNED, tuned, tuned_engines
from steadyload.runs import frames as v
from steadyload.runs.judged import JudgedCases


def equal_searches(judged: JudgedCases) -> dict[str, Any]:
    """Accuracy of the presets of equal searches, on cases that no search saw.

    Args:
        judged: by both tuned presets on every engine of :func:`.tuned_engines`, and by others.

    Returns:
        ``engines``: a row an engine, with the parameters that its search found; ``behind``:
        accuracy of the best one minus its; ``more``: its own minus that of ``ps_opt`` on it.
        ``worse``: the rows of engines that are significantly less accurate than the best one.
    """
    entries = tuned(preset=EQUAL)
    found = {name: entries[name].made_by["found"] for name in tuned_engines()}
    specs = {f"{EQUAL}@{name}": name for name in found}
    frame = v.verdicts(judged.of([*specs, *(f"{TUNED}@{name}" for name in found)]))
    right = v.share(frame, "right", ["method"])[list(specs)]
    best = v.best(right)
    pairs = [(best, spec) for spec in specs if spec != best]
    pairs += [(spec, f"{TUNED}@{name}") for spec, name in specs.items()]
    tests = v.pairs(frame, chosen=pairs)["difference"]
    rows = pd.DataFrame(
        {
            "engine": list(found),
            "genotypes": [one["genotypes"] for one in found.values()],
            "searched_on": [one["cases"] for one in found.values()],
            "found_there": [one["accuracy"] for one in found.values()],
            "right": right,
            "behind": [tests.get((best, spec)) for spec in specs],
            "more": [tests[spec, f"{TUNED}@{name}"] for spec, name in specs.items()],
        },
        index=list(specs),
    )
    known = rows.dropna(subset="behind")
    return {
        "engines": rows,
        "worse": known[[one.low > 0.0 for one in known["behind"]]].to_dict("records"),
        "cases": len(judged.said),
        "item_lists": judged.clusters.nunique(),
    }
