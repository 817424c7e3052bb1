"""Training, validation and test: all layouts of one item list lie in one of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.sizes import MOST_SMALL

_TEST_ALONE = ("test",)

FURTHER_DRAWS = "further_draws"
"""Entry of the manifest of a set of large layouts: what was added to it, a mapping a draw."""

_KINDS = 2 * len(Scenario)
"""Kinds of cases of a balanced part: stable and unstable ones in every scenario."""


@dataclass(frozen=True, slots=True)
class SplitSizes:
    """Sizes of the held-out splits.

    Args:
        test, validation: cases a scenario, half of them stable: even numbers.
        test_lists, validation_lists: item lists of every class that these cases come from, or more
            where so many do not hold enough. Intervals are clustered by item list.
        most_of_list: cases of an item list, at most; None for the other rule. With it all item
            lists are for ``parts``, and none of the other numbers matters; see
            :func:`spread_over_lists`.
        parts: that the item lists are dealt to, those of every class in turn.

    Raises:
        BenchmarkError: a number is odd or below 2, or ``most_of_list`` below 6.
    """

    test: int = 1000
    validation: int = 300
    test_lists: int = 5
    validation_lists: int = 2
    most_of_list: int | None = None
    parts: tuple[str, ...] = _TEST_ALONE

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(self.parts))  # a stored one is a list
        for name, size in (("test", self.test), ("validation", self.validation)):
            if size < 2 or size % 2:
                raise BenchmarkError(f"{name} is {size}; allowed: an even number, 2 or more")
        if self.most_of_list is not None and self.most_of_list < _KINDS:
            raise BenchmarkError(
                f"most_of_list is {self.most_of_list}; allowed: {_KINDS} or more, a stable and an "
                "unstable case a scenario"
            )

    def stored(self) -> dict[str, Any]:
        """The sizes as the manifest of a set holds them: what is not usual of the later ones."""
        usual = {"most_of_list": None, "parts": _TEST_ALONE}
        return {k: v for k, v in asdict(self).items() if k not in usual or v != usual[k]}


SIZES = SplitSizes()
"""Those of the set that comes with the package."""


def assign_splits(cases: pd.DataFrame, *, seed: int, sizes: SplitSizes = SIZES) -> pd.DataFrame:
    """The cases with the columns ``split`` and ``rank``.

    Instances are drawn at random, one of every class at a time, for the test until they are as many
    as asked for and hold enough stable and unstable cases in every scenario, then likewise for the
    validation; all others are for training. Of the test and validation instances as many cases as
    asked for are drawn by scenario, stable and unstable in turn; the others belong to no split, so
    that nothing of a test instance is ever learnt from. Ranks of training cases are drawn, too.

    Args:
        cases: labelled or not, with ``instance`` and ``item_class``; only ``done`` ones take part.
        seed: root of the draws, 0 or more.
        sizes: how many.

    Raises:
        BenchmarkError: too few stable or unstable cases.
    """
    if sizes.most_of_list is not None:
        return spread_over_lists(cases, seed=seed, most=sizes.most_of_list, parts=sizes.parts)
    rounds = drawn_instances(cases, seed=seed)
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    done = cases[cases["status"] == "done"]
    done = done.assign(stable=done["failing_step"].isna())
    split = pd.Series(pd.NA, cases.index, dtype="string")
    rank = pd.Series(pd.NA, cases.index, dtype="Int32")
    for name, size, lists in (
        ("test", sizes.test, sizes.test_lists),
        ("validation", sizes.validation, sizes.validation_lists),
    ):
        taken = _take(done, rounds, size, lists, name)
        for _, group in done[done["instance"].isin(taken)].groupby("scenario", sort=True):
            for stable, first in ((True, 0), (False, 1)):
                index = group.index[group["stable"] == stable].to_numpy()
                drawn = random.permutation(index)[: size // 2]
                split[drawn] = name
                rank[drawn] = np.arange(len(drawn)) * 2 + first
    rest = done[done["instance"].isin({i for members in rounds for i in members})]
    for _, group in rest.groupby("scenario", sort=True):
        drawn = random.permutation(group.index.to_numpy())
        split[drawn] = "train"
        rank[drawn] = np.arange(len(drawn))
    return cases.assign(split=split.astype(object).where(split.notna(), None), rank=rank)


def spread_over_lists(
    cases: pd.DataFrame, *, seed: int, most: int, parts: Sequence[str] = _TEST_ALONE
) -> pd.DataFrame:
    """The cases with the columns ``split`` and ``rank``, for a set that nothing is learnt from.

    Item lists are dealt to the parts, those of every class in turn. Of every item list up to a
    sixth of ``most`` stable and as many unstable cases of every scenario take part; they are drawn
    in turns over the lists, until the stable or the unstable ones of the scenario run out. So the
    first ranks come from as many item lists as a part has.

    Args:
        cases: labelled or not, with ``instance`` and ``item_class``; only ``done`` ones take part.
        seed: root of the draws, 0 or more.
        most: cases of an item list, 6 or more.
        parts: one or more.

    Raises:
        BenchmarkError: a part has no stable or no unstable case of a scenario.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(3,)))
    done = cases[cases["status"] == "done"]
    drawn = pd.Series(random.permutation(len(done)), done.index)
    lists = sorted(cases["instance"].unique())
    turn_of_list = dict(zip(lists, random.permutation(len(lists)), strict=True))
    order = pd.DataFrame(
        {
            "scenario": done["scenario"],
            "stable": done["failing_step"].isna(),
            "list": done["instance"].map(turn_of_list),
            "part": done["instance"].map(_dealt(cases, parts)),
            "drawn": drawn,
        }
    ).sort_values("drawn")
    order["turn"] = order.groupby(["scenario", "stable", "list"]).cumcount()
    order = order[order["turn"] < most // _KINDS].sort_values(["turn", "list"])
    split = pd.Series(pd.NA, cases.index, dtype="string")
    rank = pd.Series(pd.NA, cases.index, dtype="Int32")
    for (part, scenario), group in order.groupby(["part", "scenario"]):
        kinds = [group.index[group["stable"] == stable] for stable in (True, False)]
        size = min(map(len, kinds))
        if not size:
            raise BenchmarkError(f"{part}: no stable or no unstable case in scenario {scenario}")
        for first, index in enumerate(kinds):
            split[index[:size]] = part
            rank[index[:size]] = np.arange(size) * 2 + first
    return cases.assign(split=split.astype(object).where(split.notna(), None), rank=rank)


def _dealt(cases: pd.DataFrame, parts: Sequence[str]) -> dict[str, str]:
    """The part of every item list."""
    of_class = cases.groupby("item_class")["instance"].unique()
    return {
        name: parts[place % len(parts)]
        for lists in of_class
        for place, name in enumerate(sorted(lists))
    }


MOST_STABLE = 0.7
"""Largest share of stable cases in a held-out part of :func:`split_by_instance`."""


@dataclass(frozen=True, slots=True)
class FurtherDraw:
    """Instances that were added to a set of :func:`split_by_instance`: none is for training.

    Args:
        instances: their names.
        seed: root of their draws, 0 or more.
        test: share of them for the test; the others are for the validation.
    """

    instances: tuple[str, ...]
    seed: int
    test: float


def split_by_instance(
    cases: pd.DataFrame,
    *,
    seed: int,
    test: float,
    validation: float,
    further: Sequence[FurtherDraw] = (),
) -> pd.DataFrame:
    """The cases with the columns ``split`` and ``rank``, for a set that is not balanced.

    Whole instances are drawn for the test and the validation, and all others are for training.
    Instances of a further draw are drawn by themselves. Ranks do not depend on labels: in a
    held-out part cases of the first draw with up to :data:`MOST_SMALL` items come first, then
    larger ones, then those of further draws.

    Where more than :data:`MOST_STABLE` of the labelled small cases of a held-out part are stable,
    those of the last ranks are in no part; likewise for the larger ones by themselves. So labels
    of large cases move no small one. Ranks of what is left out, and those that larger cases of the
    first draw had among the small ones, stay empty.

    Args:
        cases: labelled or not, with ``instance`` and ``item_count``; which instances are drawn does
            not depend on labels.
        seed: root of the draws, 0 or more.
        test: share of the instances.
        validation: likewise.
        further: draws of instances that were added later, in their order.
    """
    added = {name for draw in further for name in draw.instances}
    later = cases["instance"].isin(added)
    shares = {"test": test, "validation": validation}
    draws = [_by_instance(cases[~later], seed, shares, "train")]
    for draw in further:
        own = cases[cases["instance"].isin(draw.instances)]
        draws.append(_by_instance(own, draw.seed, {"test": draw.test}, "validation"))
    split = pd.concat([part for part, _ in draws]).reindex(cases.index)
    drawn = pd.concat([order for _, order in draws])
    # Orders of all draws as one: those of a further draw follow.
    turn = drawn.reindex(cases.index)
    for place, (_, order) in enumerate(draws):
        turn[order.index] += place * len(cases)
    large = cases["item_count"] > MOST_SMALL
    behind = later | (large & (split != "train"))
    groups = [split, cases["scenario"]]
    first = (~later).groupby(groups).transform("sum")
    rank = turn.where(~later).groupby(groups).rank() - 1
    rank = rank.mask(behind, first + turn.where(behind).groupby(groups).rank() - 1).astype("Int32")
    done = cases["status"] == "done"
    stable = done & cases["failing_step"].isna()
    for name in ("test", "validation"):
        for size in (~large, large):
            held = (split == name) & size
            fails = int((held & done & ~stable).sum())
            most = int(fails * MOST_STABLE / (1.0 - MOST_STABLE) + 1e-9)
            over = turn[held & stable].sort_values().index[most:]
            split[over] = None
    return cases.assign(split=split, rank=rank.where(split.notna(), pd.NA))


def _by_instance(
    cases: pd.DataFrame, seed: int, shares: Mapping[str, float], rest: str
) -> tuple[pd.Series, pd.Series]:
    """Part and place of every case: whole instances, drawn at random.

    Args:
        cases: with ``instance``.
        seed: root of the draws.
        shares: of the instances, by part.
        rest: part of all others.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(2,)))
    instances = random.permutation(sorted(cases["instance"].unique()))
    ends = np.cumsum(np.round(np.array(list(shares.values())) * len(instances)).astype(int))
    part = pd.Series(rest, instances)
    for name, start, end in zip(shares, (0, *ends), ends, strict=False):
        part.iloc[start:end] = name
    order = pd.Series(random.permutation(len(cases)), cases.index)
    return cases["instance"].map(part).astype(object), order


def splits_of_manifest(cases: pd.DataFrame, manifest: Mapping[str, Any]) -> pd.DataFrame:
    """:func:`split_by_instance` by the seeds, shares and further draws of a set's manifest.

    Args:
        cases: as there.
        manifest: of a set of large layouts; without shares all cases are for training.
    """
    further = [
        FurtherDraw(tuple(draw["instances"]), draw["seed"], draw["test"])
        for draw in manifest.get(FURTHER_DRAWS, ())
    ]
    return split_by_instance(
        cases,
        seed=manifest.get("seed", 0),
        test=manifest.get("test", 0.0),
        validation=manifest.get("validation", 0.0),
        further=further,
    )


def drawn_instances(cases: pd.DataFrame, *, seed: int) -> list[list[str]]:
    """All instances in the order in which splits take them: one of every class at a time.

    Args:
        cases: with ``instance`` and ``item_class``; labelled or not, the order is the same.
        seed: root of the draws, 0 or more.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0,)))
    shuffled = [
        random.permutation(sorted(group["instance"].unique())).tolist()
        for _, group in cases.groupby("item_class", sort=True)
    ]
    longest = max(map(len, shuffled), default=0)
    return [[names[k] for names in shuffled if k < len(names)] for k in range(longest)]


def _take(
    done: pd.DataFrame, rounds: list[list[str]], size: int, lists: int, name: str
) -> set[str]:
    """Remove ``lists`` rounds, and as many more as it takes to have ``size`` balanced cases."""
    taken = {instance for members in rounds[:lists] for instance in members}
    del rounds[:lists]
    scenarios = done["scenario"].unique()
    while True:
        held = done[done["instance"].isin(taken)].groupby(["scenario", "stable"]).size()
        least = min(
            (held.get((s, stable), 0) for s in scenarios for stable in (True, False)), default=0
        )
        if least >= size // 2:
            return taken
        if not rounds:
            raise BenchmarkError(
                f"{name}: only {least} stable or unstable cases in some scenario are left; "
                f"{size // 2} of each are asked for"
            )
        taken |= set(rounds.pop(0))
