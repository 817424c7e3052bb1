"""Record golden verdicts anew: ``python tests/golden/record.py [--deep]``.

First raise the version of the part that says something else, or what is stored would be taken for
what is judged now.
"""

import argparse
import json

from computations import FILE as COMPUTATIONS
from computations import computed
from golden_cases import FILE as CASES
from golden_cases import chosen_names
from golden_methods import DEEP, array, asked
from verdicts import FOLDER, judged, write

SECONDS = {"quick": 3.0, "deep": 20.0}
"""CPU time that a method may take: how many cases are kept of one that is slow."""


def main() -> None:
    """Write the names of cases, then verdicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--deep", action="store_true", help="those of the deep test, too")
    deep = parser.parse_args().deep
    FOLDER.mkdir(exist_ok=True)
    names = {kind: chosen_names(DEEP, planar=kind == "planar") for kind in ("spatial", "planar")}
    CASES.write_text(json.dumps({**names, "array": array()}, indent=0) + "\n")
    for name in ("quick", "deep") if deep else ("quick",):
        spent: dict[str, float] = {}
        write(FOLDER / f"{name}.parquet", judged(asked(deep=name == "deep"), spent, SECONDS[name]))
        for spec, seconds in sorted(spent.items(), key=lambda entry: -entry[1])[:12]:
            print(f"{seconds:7.2f} s CPU  {spec}")
        print(f"{name}: {sum(spent.values()):.1f} s CPU")
    COMPUTATIONS.write_text(json.dumps(computed(), indent=1) + "\n")


if __name__ == "__main__":
    main()
