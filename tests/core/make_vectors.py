"""Make the test vectors anew: ``python tests/core/make_vectors.py``.

Layouts are drawn by a fixed seed, and taken from the shipped sets. One is kept where a part that is
asked of it runs a jump between two blocks of C that no layout before ran: the library is built by
gcc without optimisation and with a trace of these (trace.c). A sample of the others fills up.
EXPECTED NUMBERS ARE THOSE OF THE LIBRARY AS IT IS: make vectors anew only where the numbers are to
change, and look at what the command says has changed.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import zlib
from pathlib import Path

import numpy as np

from steadyload.core import building

HERE = Path(__file__).parent
DRAWN, SHIPPED, KEPT, OTHERS, FEW = 6000, 250, 3200, 12, 9
"""Layouts that are drawn, shipped ones of a set, layouts of the file, one of how many that fill up
is asked all parts, and the most boxes of these.
"""


def traced(folder: str) -> Path:
    """The library with a trace of the jumps that run."""
    flags = [flag for flag in building.FLAGS if not flag.startswith("-O")]
    how = ["gcc", *flags, "-O0", "-fsanitize-coverage=trace-pc", "-shared", "-fPIC"]
    sources = map(str, (*sorted(building.HERE.glob("*.c")), HERE / "trace.c"))
    made = Path(folder) / "traced.lib"
    subprocess.run([*how, *sources, "-lm", "-o", str(made)], check=True)
    return made


def candidates(draw):
    """Names and layouts: those that are shipped; then of few boxes, every thirtieth of many."""
    import drawn

    yield from drawn.shipped(SHIPPED, 60)
    for k in range(DRAWN):
        yield f"drawn {k}", drawn.drawn(draw, 40 if k % 30 == 29 else FEW)


def choose(vectors):
    """Rows of layouts with the parts that are asked of each; their numbers are still missing."""
    from steadyload.core.library import LIBRARY

    before, fresh = (ctypes.c_uint32.in_dll(LIBRARY, name) for name in ("before", "fresh"))
    draw, new, others, jumps = np.random.default_rng(1), [], [], 0
    for name, arrays in candidates(draw):
        row = vectors.Row(name, zlib.crc32(name.encode()) % 10_000, arrays, {})
        for part in asked_of(vectors, row):
            before.value = 0
            vectors.asked(part, arrays, row.variant)
            if fresh.value > jumps:
                row.expected[part] = {}
            jumps = fresh.value
        (new if row.expected else others).append(row)
    print(f"{len(new)} layouts run {jumps} jumps, {len(others)} more run no other one", flush=True)
    fill = draw.permutation(len(others))[: max(KEPT - len(new), 0)].tolist()
    for place, k in enumerate(fill):
        if place % OTHERS == 0 and len(others[k].arrays[2]) <= FEW:
            others[k].expected.update((part, {}) for part in vectors.PARTS)
    chosen = new + [others[k] for k in sorted(fill)]
    for row in chosen:
        row.expected.update((part, {}) for part in vectors.OF_ALL)
    return chosen


def asked_of(vectors, row):
    """Parts that a layout may be asked: some have many numbers where there are many boxes."""
    few = len(row.arrays[2]) <= FEW
    return [part for part in vectors.PARTS if few or part not in vectors.OF_FEW]


def main() -> None:
    """The command."""
    with tempfile.TemporaryDirectory() as folder:
        made = traced(folder)
        building.name = lambda: str(made)  # an absolute path: it is loaded in place of the other
        import vectors

        rows = choose(vectors)
        for row in rows:
            for part, numbers in row.expected.items():
                numbers |= vectors.asked(part, row.arrays, row.variant)
        before = vectors.read() if vectors.FILE.exists() else []
        for part in vectors.PARTS if before else ():
            changed = vectors.differences(part, before)
            print(f"{part}: {len(changed)} changed in the layouts before", *changed[:5], sep="\n")
        vectors.write(rows)
        size = vectors.FILE.stat().st_size
        print(f"{vectors.FILE.name}: {len(rows)} layouts, {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
