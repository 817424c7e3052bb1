"""Record golden verdicts anew: ``python tests/golden/record.py``; flags: see ``--help``.

First raise the version of the part that says something else, or what is stored would be taken for
what is judged now.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "perturbing"))

from computations import FILE as COMPUTATIONS
from computations import computed
from golden_cases import FILE as CASES
from golden_cases import chosen_names
from golden_methods import DEEP, array, asked
from tosses import FILE as TOSSES
from tosses import recorded
from verdicts import FOLDER, ONE_MACHINE, judged, plan, read, turned, write

from steadyload.engines.registry import capabilities
from steadyload.methods.registry import make_method

SECONDS = {"quick": 3.0, "deep": 20.0}
"""CPU time that a method may take: how many cases are kept of one that is slow."""


def main() -> None:
    """Write the names of cases, then verdicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--deep", action="store_true", help="those of the deep test, too")
    parser.add_argument(
        "--one-machine", action="store_true",
        help="only which of the kept ones hold on one kind of machine alone",
    )  # fmt: skip
    parser.add_argument(
        "--tosses", action="store_true",
        help="only where measured tosses end, which are not kept here, by installed engines",
    )  # fmt: skip
    given = parser.parse_args()
    if given.tosses:
        TOSSES.write_text(json.dumps(recorded(), indent=0) + "\n")
        return
    if given.one_machine:
        ONE_MACHINE.write_text(json.dumps(on_one_machine(), indent=0) + "\n")
        return
    deep = given.deep
    FOLDER.mkdir(exist_ok=True)
    names = {kind: chosen_names(DEEP, planar=kind == "planar") for kind in ("spatial", "planar")}
    CASES.write_text(json.dumps({**names, "array": array()}, indent=0) + "\n")
    for name in ("quick", "deep") if deep else ("quick",):
        spent: dict[str, float] = {}
        write(FOLDER / f"{name}.parquet", judged(asked(deep=name == "deep"), spent, SECONDS[name]))
        for spec, seconds in sorted(spent.items(), key=lambda entry: -entry[1])[:12]:
            print(f"{seconds:7.2f} s CPU  {spec}")
        print(f"{name}: {sum(spent.values()):.1f} s CPU")
    ONE_MACHINE.write_text(json.dumps(on_one_machine(), indent=0) + "\n")
    COMPUTATIONS.write_text(json.dumps(computed(), indent=1) + "\n")


def on_one_machine() -> list[tuple[str, ...]]:
    """Keys of the verdicts in single precision that moved starts turn."""
    found: set[tuple[str, ...]] = set()
    for name in ("quick", "deep"):
        golden, _ = read(FOLDER / f"{name}.parquet")
        single = [each for each in plan(golden, deep=name == "deep") if _is_single(each.spec)]
        specs = {each.spec for each in single}
        found |= turned([row for row in golden if row["method"] in specs], single)
    return sorted(found)


def _is_single(spec: str) -> bool:
    engine = make_method(spec).spec.engine
    return engine is not None and capabilities(engine).single_precision


if __name__ == "__main__":
    main()
