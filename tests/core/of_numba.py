"""Make the test vectors with the numbers of numba: ``python tests/core/of_numba.py``.

What vectors.py calls of the C library is replaced by the kernels, once the layouts are chosen;
features by the kernels of learned methods as they were before they were deleted. With
``--compare`` the file stays, and what the kernels find otherwise is printed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import make_vectors
import numpy as np

BEFORE = "ce884cd3^"
"""The last commit with the compiled features of learned methods."""


def fixed(*arrays):
    """Copies as a layout has them."""
    made = tuple(np.array(each, dtype=float, order="C") for each in arrays)
    for each in made:
        each.setflags(write=False)
    return made


def features_before():
    """The modules support, features and ranges of that commit."""
    folder = Path(tempfile.mkdtemp()) / "learners_before"
    folder.mkdir()
    (folder / "__init__.py").touch()
    for name in ("support", "features", "ranges", "convex_hull", "compiled"):
        shown = subprocess.run(
            ["git", "show", f"{BEFORE}:learners/{name}.py"],
            capture_output=True,
            text=True,
            check=True,
        )
        text = shown.stdout.replace("steadyload.learners.", "learners_before.")
        text = text.replace('_COMPILED = ("features", "inference",', '_COMPILED = ("features",')
        (folder / f"{name}.py").write_text(text)
    sys.path.insert(0, str(folder.parent))
    from learners_before import features, ranges, support

    return features, ranges, support


def replace(vectors):
    """In vectors.py, the library by the kernels."""
    from steadyload.core.library import Finding
    from steadyload.core.loading import Loaded
    from steadyload.core.session import Patches
    from steadyload.core.timed import Closest, Group, Moved
    from steadyload.core.whole import Contacts
    from steadyload.statics import kernels
    from steadyload.statics.kernels import growing as grown
    from steadyload.statics.kernels import least_energy, placing
    from steadyload.statics.kernels import loading as loads
    from steadyload.statics.kernels.constants import FULL

    features, ranges, support = features_before()
    numbers = lambda how: tuple(getattr(how, name) for name, _ in how._fields_)  # noqa: E731

    class Given:
        def __init__(self, *arrays):
            self.arrays = fixed(*arrays)

        def judge(self, rule, alpha):
            lower, upper, _, _, floor = self.arrays
            if rule == vectors.SUPPORTED:
                step, share = kernels.base_support.first_with_little_support(
                    lower, upper, floor, alpha
                )
                fails = step < len(lower)
                return Finding(int(fails), step, step if fails else -1, share)
            if rule == vectors.CARRIED:
                step, item, is_carried = kernels.sme.first_unsupported(*self.arrays)
                return Finding(int(item >= 0), step, item, float(is_carried))
            ended, step, item = kernels.balance.first_unbalanced(*self.arrays, alpha)
            return Finding(ended, step, item, 0.0)

        def margin(self, most):
            ended, margin, step, item = kernels.margin.margin_as_planned(*self.arrays, most)
            return Finding(ended, step, item, margin)

    def contacts(lower, upper, floor):
        found = kernels.contacts.contacts_of(*fixed(lower, upper, floor))
        return Contacts(*(getattr(found, name) for name in Contacts._fields))

    class Session:
        def __init__(self, limits):
            self.arrays = grown.first_arrays(limits[:3], limits[3:6], limits[6:])
            self.kept = tuple(self.arrays)

        def grow(self):
            self.arrays = grown.with_more_room(self.arrays)
            self.kept = tuple(self.arrays)

        def call(self, function, box, *how):
            while True:
                self.arrays.limits[grown.BOX :] = box
                found = function(self.kept, *how)
                if found[0] != FULL:
                    return found
                self.grow()

        def put(self, box):
            return self.call(grown.put, box)[0]

        def place(self, box, rule, alpha):
            ended, item, number = self.call(placing.place, box, rule, alpha)
            return Finding(ended, len(self), item, number)

        def endings(self, box, positions, rule, alpha):
            found, done = np.empty(len(positions), dtype=np.int8), 0
            self.arrays.limits[grown.BOX :] = box
            while done < len(positions):
                done = placing.stand(self.kept, rule, alpha, positions, found, done)
                if done < len(positions):
                    self.grow()
            return found

        def cut(self, count):
            grown.take_off(self.kept, count)

        def __len__(self):
            return int(self.arrays.counts[grown.ITEMS])

        def near(self, lower, upper, wider):
            low, high, _ = self.arrays.vectors
            return kernels.cells.items_near(
                low, high, self.arrays.cells, len(self), self.arrays.limits, lower, upper, wider
            )

        def below(self, box):
            start, end, *_ = self.arrays.blocks[:, box].tolist()
            return Patches(
                self.arrays.links[0, start:end], self.arrays.patches[start:end],
                self.arrays.presses[0, start:end],
            )  # fmt: skip

    def is_undecided(ended):
        return 7 if ended == 6 else ended

    def first_moved(given, limit, how):
        ended, *others = kernels.timed_balance.first_moved_of(*given.arrays, limit, *numbers(how))
        return Moved(is_undecided(ended), *others, 0.0)

    class Followed:
        def __init__(self, given, margin, limit):
            self.given = given.arrays
            self.of = kernels.timed_balance.begin(*given.arrays)
            kernels.contacts.draw_in(self.of.contacts.patches, margin)
            self.of.work[1] = limit
            self.moves, self.answers, self.solved = self.of.moves, self.of.answers, self.of.solved
            self.counts, self.pressing, self.pushes = (
                self.of.counts,
                self.of.corners,
                self.of.pushes,
            )
            self.farthest, self.beyond = self.of.most, self.of.beyond

        def place(self, step, how):
            ended, *others = kernels.timed_balance.place(step, self.of, *numbers(how))
            return Moved(is_undecided(ended), step, *others)

        def group(self, step):
            return Group(*kernels.timed_balance.moving_group(step, self.of))

        def moved(self, step, group, how):
            ended, *others = kernels.timed_balance.moved(step, group, self.of, *numbers(how))
            return Moved(is_undecided(ended), step, *others)

        def is_near_its_edge(self, step, margin):
            lower, upper, _, offsets, _ = self.given
            return kernels.balance.is_near_its_edge(
                step, self.of.contacts, lower, upper, offsets, margin
            )

    class Held:
        def __init__(self, given, margin=0.0):
            self.of = kernels.balance.begin(*given.arrays, margin)

        def place(self, step):
            return kernels.balance.balance_whole_group(step, self.of)

        def group(self, step):
            return kernels.balance.joined(step, self.of.contacts)

    def closest_to_balance(given, items, used, corners, grow):
        lower, upper, weights, offsets, _ = given.arrays
        found, *others = kernels.local_balance.closest_to_balance(
            items, used.astype(np.int64), corners.copy(), 0.5 * (lower + upper) + offsets, weights,
            lower, upper, grow,
        )  # fmt: skip
        return Closest(found, *others)

    class Boxes:
        def __init__(self, *arrays):
            self.of = loads.Boxes(*arrays)
            self.planned = self.of.planned

        def places_among(self, *how):
            return loads.places_among(tuple(self.of), *how)

        def cost(self, places):
            return loads.cost(tuple(self.of), places)

    class Loading:
        def __init__(self, limits, boxes):
            self.boxes, self.grown = tuple(boxes.of), Session(limits)
            self.turns = tuple(loads.no_turns(len(boxes.of.weights)))

        def begin(self, places, margins, refused, first):
            self.wishes = places, margins, refused
            loads.begin(self.grown.kept, self.boxes, self.turns, *self.wishes, first)

        def load(self, *, reorder, looks):
            while True:
                ended = loads.load(
                    self.grown.kept, self.boxes, self.turns, *self.wishes, reorder, looks
                )
                if ended != loads.FULL:
                    self.looks = ended != loads.ALL
                    return ended == loads.ALL
                grown.take_off(self.grown.kept, 0)
                self.turns = tuple(loads.no_turns(len(self.wishes[0])))
                self.grown.grow()

        @property
        def looked_at(self):
            return loads.Turns(*self.turns).looked_at

        def say(self, stays, *, reorder):
            place, box = len(self.grown) - 1, self.looked_at
            if not stays:
                grown.take_off(self.grown.kept, place)
            loads.said(self.turns, place, box, stays, reorder)

        def loaded(self):
            turns = loads.Turns(*self.turns)
            order = turns.order[: len(self.grown) - self.looks].tolist()
            return Loaded(order, turns.stuck)

        def tried(self):
            return self.turns[0]

        def first_standing(self, box, places, margin, most):
            found = np.empty(most, dtype=np.int64)
            while True:
                count = loads.first_standing(
                    self.grown.kept, self.boxes, box, places, margin, self.wishes[2], found
                )
                if count >= 0:
                    return found[:count]
                self.grown.grow()

    class Energy:
        def __init__(
            self, starts, rows, diagonal, column_starts, column_rows, values, right, presses
        ):
            whole = lambda each: each.astype(np.int64)  # noqa: E731
            self.factors = least_energy.Factors(
                whole(starts), whole(rows), np.zeros(len(rows)), diagonal.copy()
            )
            self.columns = least_energy.Columns(whole(column_starts), whole(column_rows), values)
            self.right, self.presses = right.copy(), presses.copy()
            self.held, self.multipliers = np.zeros(len(presses), dtype=bool), np.zeros(len(right))

        def pulls(self, corners, equations):
            pulls = np.empty(len(corners))
            ended = least_energy.solved(
                self.factors, self.columns, corners.astype(np.int64), equations.astype(np.int64),
                self.right, self.presses, self.held, self.multipliers, pulls,
            )  # fmt: skip
            return pulls if ended else None

    def support_table(given):
        lower, upper, weights, offsets, floor = given.arrays
        return support.support_table(lower, upper, weights, 0.5 * (lower + upper) + offsets, floor)

    def support_features(given):
        return features.features_of(*given.arrays, (1.0, 1.0, 1.0), features.FeatureKind.SUPPORT)

    def plain_features(given, pallet):
        return features.features_of(*given.arrays, tuple(pallet), features.FeatureKind.PLAIN)

    vectors.whole = SimpleNamespace(Given=Given, contacts=contacts)
    vectors.session = SimpleNamespace(Session=Session)
    vectors.timed = SimpleNamespace(
        first_moved=first_moved, Followed=Followed, Held=Held, closest_to_balance=closest_to_balance
    )
    vectors.loading = SimpleNamespace(Boxes=Boxes, Loading=Loading)
    vectors.forces = SimpleNamespace(
        Energy=Energy, least_squares=kernels.least_squares.nonnegative_least_squares
    )
    vectors.learned = SimpleNamespace(
        support_table=support_table, support_features=support_features,
        plain_features=plain_features, quantities=lambda given: ranges._quantities(*given.arrays),
    )  # fmt: skip


if __name__ == "__main__":
    if sys.argv[1:] == ["--compare"]:
        import vectors

        replace(vectors)
        for part in vectors.PARTS:
            lines = vectors.differences(part, vectors.read())
            print(part, len(lines), *lines[:4], sep="\n", flush=True)
    else:
        make_vectors.main(replace)
