"""Features and networks of the C library against those that numba compiles, layout by layout.

    python tests/core/compare_features.py [--part headline|lists|random] [--times]

Says what differs, in units in the last place; ends with 1 if a verdict does, or more than allowed.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from steadyload.layouts.benchmark.dataset import load_benchmark
from steadyload.learners.features import FeatureKind, features_of, names
from steadyload.learners.inference import Network
from steadyload.learners.ranges import _inside, _quantities
from steadyload.learners.support import COLUMNS, support_table
from steadyload.learners.weights import load_weights

CORE = Path(__file__).resolve().parents[2] / "harness" / "core"
SANITIZED = ("-g", "-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all", "-DSL_EACH")
MOST = 2
"""Units in the last place that what takes a log, a tanh or an exp may differ by."""


class Given(NamedTuple):
    """One layout, as kernels take it."""

    lower: Any
    upper: Any
    weights: Any
    offsets: Any
    floor: Any
    pallet: Any


class Library:
    """The functions of learned.h, on NumPy arrays."""

    def __init__(self, path: Path) -> None:
        self._c = ctypes.CDLL(str(path))
        self._c.sl_work_new.restype = ctypes.c_void_p
        self._work = ctypes.c_void_p(self._c.sl_work_new())

    def table(self, given: Given) -> Any:
        """See :func:`steadyload.learners.support.support_table`."""
        out = np.full((len(given.weights), len(COLUMNS)), np.nan)
        assert not self._c.sl_support_table(self._work, *_pointers(given[:5]), _at(out))
        return out

    def features(self, given: Given, kind: FeatureKind) -> Any:
        """See :func:`steadyload.learners.features.features_of`."""
        if kind is FeatureKind.PLAIN:
            out = np.full((len(given.weights), 14), np.nan, dtype=np.float32)
            self._c.sl_plain_features(*_pointers(given[:4]), _at(given.pallet), _at(out))
            return out
        out = np.full((len(given.weights), len(COLUMNS)), np.nan, dtype=np.float32)
        assert not self._c.sl_support_features(self._work, *_pointers(given[:5]), _at(out))
        return out

    def quantities(self, given: Given) -> Any:
        """See :mod:`steadyload.learners.ranges`."""
        out = np.full((len(given.weights), 6), np.nan)
        self._c.sl_quantities(*_pointers(given[:5]), _at(out))
        return out

    def inside(self, quantities: Any, least: Any, most: Any) -> int:
        """Number of first boxes that are within."""
        return int(self._c.sl_inside(len(quantities), _at(quantities), _at(least), _at(most)))

    def start(self, network: Network) -> list[Any]:
        """Outputs and cells of all layers before the first step."""
        widths = [len(layer.recurrent) for layer in network._layers]
        return [np.zeros((2, width), np.float32) for width in widths]

    def calls_of(self, network: Network, rows: Any, states: list[Any]) -> list[Callable[[], Any]]:
        """What fills the outputs of every layer, and at last the probabilities."""
        calls: list[Callable[[], Any]] = []
        for layer, state in zip(network._layers, states, strict=True):
            out = np.empty((len(rows), state.shape[1]), np.float32)
            arrays = (rows, layer.inward, layer.recurrent, layer.bias, state, out)
            sizes = (*rows.shape, state.shape[1])
            calls.append(partial(self._c.sl_run_layer, self._work, *sizes, *map(_at, arrays)))
            rows = out
        found = np.empty(len(rows), np.float32)
        last = ctypes.c_double(network._last)
        args = (*rows.shape, _at(rows), _at(network._head), last, _at(found))
        calls.append(partial(self._c.sl_decide, *args))
        calls.append(lambda: found)
        return calls

    def chances(self, network: Network, rows: Any, pieces: int = 1) -> Any:
        """See :meth:`Network.probabilities`; with pieces, each goes on where the last one ended."""
        states, found = self.start(network), []
        for piece in np.array_split(rows, pieces):
            *calls, answer = self.calls_of(network, np.ascontiguousarray(piece), states)
            for call in calls:
                call()
            found.append(answer())
        return np.concatenate(found)

    def call_of(self, given: Given, kind: FeatureKind) -> Callable[[], Any]:
        """What fills features, again and again."""
        out = np.empty((len(given.weights), len(names(kind))), dtype=np.float32)
        if kind is FeatureKind.PLAIN:
            call = self._c.sl_plain_features
            return partial(call, *_pointers((*given[:4], given.pallet, out)))
        return partial(self._c.sl_support_features, self._work, *_pointers((*given[:5], out)))


def _at(array: Any) -> Any:
    """Its address, which keeps the array."""
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)


def _pointers(arrays: Any) -> list[Any]:
    return [len(arrays[2]), *map(_at, arrays)]


def build(into: Path, *more: str) -> Path:
    """The library, by the flags that it is always built with, and more."""
    spec = importlib.util.spec_from_file_location("building", CORE / "building.py")
    assert spec
    assert spec.loader
    building = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(building)
    made = into / "core.so"
    sources = map(str, sorted(CORE.glob("*.c")))
    how = (*building.FLAGS, *more, "-shared", "-fPIC")
    subprocess.run([*building.compiler(), *how, *sources, "-o", str(made), "-lm"], check=True)
    return made


def shipped(name: str | None, limit: int | None) -> Iterator[Given]:
    """All layouts of a labelled set, spread evenly where there is a limit."""
    benchmark = load_benchmark(name)
    batch = benchmark.batch(benchmark.cases)
    count = len(batch.starts) - 1
    for k in range(0, count, max(1, count // limit) if limit else 1):
        own = slice(*batch.starts[k : k + 2])
        boxes = (batch.lower[own], batch.upper[own], batch.weights[own], batch.mass_offsets[own])
        yield Given(*boxes, batch.floors[k], np.array(batch.pallets[k].size, dtype=float))


def drawn(count: int, seed: int = 7, most: int = 24) -> Iterator[Given]:
    """Boxes dropped onto a deck, on grids of few lengths: edges, tops and centres tie.

    Some float or sink a little, some stand out over the deck, and some orders are odd: boxes come
    that are below others.
    """
    rng = np.random.default_rng(seed)
    pallet = np.array((120.0, 150.0, 80.0))
    for _ in range(count):
        grid = float(rng.choice((1.0, 5.0, 10.0, 0.1)))
        off = float(rng.choice((0.0, 0.0, 1e-9, 0.00999, 0.0101, 0.02, 2.0, 15.0)))
        over = float(rng.choice((0.0, 0.0, 10.0)))
        low, high = np.empty((most, 3)), np.empty((most, 3))
        size = 0
        for _ in range(rng.integers(1, most)):
            sides = np.maximum(np.round(rng.uniform(8.0, 60.0, 3) / grid) * grid, grid)
            end = pallet + over - sides
            at = np.round(rng.uniform((-over, 0, -over), (end[0], 1.0, end[2])) / grid) * grid
            if size and rng.random() < 0.5:  # flush with another
                axis = rng.choice((0, 2))
                at[axis] = (low if rng.random() < 0.5 else high)[rng.integers(size), axis]
            meets = np.minimum(high[:size, ::2], (at + sides)[::2]) - np.maximum(
                low[:size, ::2], at[::2]
            )
            under = meets.min(axis=1) > 0.0100001
            at[1] = high[:size, 1][under].max() if under.any() else 0.0
            if rng.random() < 0.2:
                at[1] += rng.choice((-1.0, 1.0)) * off
            at[1] = max(at[1], 0.0)
            if at[1] + sides[1] <= 200.0:
                low[size], high[size] = at, at + sides
                size += 1
        if rng.random() < 0.2:
            order = rng.permutation(size)
            low[:size], high[:size] = low[order], high[order]
        weights = 10 ** rng.uniform(-2.0, 3.0, size)
        if rng.random() < 0.5:
            weights = np.round(rng.uniform(1.0, 30.0, size))
        offsets = rng.uniform(-0.4, 0.4, (size, 3)) * (high - low)[:size]
        if rng.random() < 0.5:
            offsets *= 0.0
        floor = (0.0, 0.0, 120.0, 80.0, 14.4)
        if rng.random() < 0.5:
            floor = (-np.inf, -np.inf, np.inf, np.inf, 0.0)
        boxes = (low[:size].copy(), high[:size].copy(), weights, offsets)
        yield Given(*boxes, np.array(floor), pallet)


def bits(array: Any) -> Any:
    """The bits of numbers, as integers."""
    return array.view(np.int32 if array.dtype == np.float32 else np.int64)


def different(one: Any, other: Any) -> Any:
    """Mask of the numbers that are not the same, bit for bit."""
    return (bits(one) != bits(other)) & ~(np.isnan(one) & np.isnan(other))


def apart(one: Any, other: Any) -> int:
    """The greatest distance of two arrays in units in the last place; what is no number is 0."""
    unequal = different(one, other)
    a, b = bits(one)[unequal], bits(other)[unequal]
    least = np.iinfo(a.dtype).min
    a, b = (np.where(x < 0, least - x, x).tolist() for x in (a, b))
    return max((abs(x - y) for x, y in zip(a, b, strict=True)), default=0)


class Count:
    """Differences, by what is compared."""

    def __init__(self) -> None:
        self.layouts = self.steps = self.verdicts = self.failing = 0
        self.numbers: dict[str, int] = {}
        self.different: dict[str, int] = {}
        self.most: dict[str, int] = {}

    def add(self, name: str, one: Any, other: Any) -> None:
        """Note what C has and what numba has."""
        self.numbers[name] = self.numbers.get(name, 0) + one.size
        self.different.setdefault(name, 0)
        self.most.setdefault(name, 0)
        if one.tobytes() != other.tobytes():
            self.different[name] += int(different(one, other).sum())
            self.most[name] = max(self.most[name], apart(one, other))

    def verdict(self, one: Any, other: Any) -> None:
        """Note whether the step that fails, and the score of every step, are the same."""
        self.verdicts += 1
        (step, scores), (as_step, as_scores) = one, other
        self.failing += as_step < len(as_scores)
        self.different.setdefault("steps that fail", 0)
        self.different["steps that fail"] += step != as_step
        self.add("scores", scores, as_scores)

    @property
    def good(self) -> bool:
        """True if nothing differs by more than allowed."""
        exact = ("table", "quantities")
        return (
            not self.different.get("steps that fail")
            and not any(self.different[name] for name in exact)
            and all(most <= MOST for most in self.most.values())
        )


def verdict_of(chances: list[Any]) -> tuple[int, Any]:
    """The step that fails, or the number of steps, and the mean of the members' probabilities."""
    mean = chances[0] if len(chances) == 1 else np.mean(chances, axis=0, dtype=np.float32)
    fails = mean > 0.5
    return int(fails.argmax()) if fails.any() else len(mean), mean


def compare(library: Library, layouts: Iterator[Given], members: list[list[Network]]) -> Count:
    """Compare all of it on layouts."""
    count = Count()
    least, most = np.array((2.0, 5.0, 0.1, 0.0, 1.0, 0.0)), np.array((60, 90, 50, 0.3, 40, 8.0))
    for given in layouts:
        count.layouts += 1
        count.steps += len(given.weights)
        centres = 0.5 * (given.lower + given.upper) + given.offsets
        args = (given.lower, given.upper, given.weights)
        count.add("table", library.table(given), support_table(*args, centres, given.floor))
        rows = {kind: library.features(given, kind) for kind in FeatureKind}
        as_rows = {kind: features_of(*given, kind) for kind in FeatureKind}
        for kind in FeatureKind:
            count.add(f"features, {kind}", rows[kind], as_rows[kind])
        quantities, as_quantities = library.quantities(given), _quantities(*given[:5])
        count.add("quantities", quantities, as_quantities)
        inside = library.inside(quantities, least, most)
        count.different.setdefault("inside", 0)
        count.different["inside"] += inside != _inside(as_quantities, least, most)
        for networks in members:
            kind = FeatureKind.PLAIN
            if len(networks[0]._layers[0].inward) == len(COLUMNS):
                kind = FeatureKind.SUPPORT
            count.verdict(
                verdict_of([library.chances(network, rows[kind]) for network in networks]),
                verdict_of([network.probabilities(as_rows[kind]) for network in networks]),
            )
            parts = library.chances(networks[0], rows[kind], pieces=2)
            count.add("in two parts", parts, library.chances(networks[0], rows[kind]))
    return count


def _best(ways: dict[str, list[Callable[[], Any]]], rounds: int = 7) -> str:
    """CPU time a layout of every way, in turns."""
    found = dict.fromkeys(ways, np.inf)
    for _ in range(rounds):
        for name, calls in ways.items():
            begin = time.process_time()
            for call in calls:
                call()
            spent = (time.process_time() - begin) / len(calls) * 1e6
            found[name] = min(found[name], spent)
    return ", ".join(f"{name} {spent:.1f} us" for name, spent in found.items())


def times(library: Library, layouts: list[Given], title: str) -> None:
    """CPU times a layout of C (by ctypes with addresses kept), numba and NumPy, side by side."""
    for kind in FeatureKind:
        c = [library.call_of(given, kind) for given in layouts]
        numba = [partial(features_of, *given, kind) for given in layouts]
        print(f"{title}: features, {kind}: {_best({'C': c, 'numba': numba})}", flush=True)
    network = load_weights("lstm_1").networks[0]
    rows = [features_of(*given, FeatureKind.SUPPORT) for given in layouts]
    kept = [library.calls_of(network, each, library.start(network)) for each in rows]
    ways = {
        "C": [partial(lambda calls: [call() for call in calls], calls) for calls in kept],
        "numba": [partial(network.probabilities, each) for each in rows],
        "NumPy": [partial(network.probabilities_of_many, each[None]) for each in rows],
    }
    print(f"{title}: network of lstm_1: {_best(ways)}", flush=True)


def main() -> int:
    """Compare, and say how much differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=20000, help="random layouts")
    parser.add_argument("--limit", type=int, help="layouts of every shipped set; all without")
    parser.add_argument("--times", action="store_true", help="measure times, and compare nothing")
    parser.add_argument("--sanitized", action="store_true", help="with sanitizers: LD_PRELOAD them")
    parser.add_argument("--part", help="one of headline, lists, random; all without")
    parser.add_argument("--features-only", action="store_true", help="ask no networks")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        library = Library(build(Path(folder), *(SANITIZED if asked.sanitized else ())))
    if asked.times:
        for title in (None, "lists"):
            times(library, list(shipped(title, 400)), title or "headline")
        return 0
    members: list[list[Network]] = []
    if not asked.features_only:
        members = [list(load_weights(name).networks) for name in ("lstm_1", "lstm_e")]
    good = True
    for title, layouts in (
        ("headline", shipped(None, asked.limit)),
        ("lists", shipped("lists", asked.limit)),
        ("random", drawn(asked.random)),
    ):
        if asked.part not in (None, title):
            continue
        begin = time.process_time()
        count = compare(library, layouts, members)
        good = good and count.good and count.layouts > 0
        print(f"{title}: {count.layouts} layouts, {count.steps} steps, {count.verdicts} verdicts")
        print(f"  of which fail: {count.failing}; CPU {time.process_time() - begin:.0f} s")
        for name, different in count.different.items():
            of = f" of {count.numbers[name]}" if name in count.numbers else ""
            most = f", by at most {count.most[name]} ulp" if count.most.get(name) else ""
            print(f"  {name}: {different}{of} differ{most}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
