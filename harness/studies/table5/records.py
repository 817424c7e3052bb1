"""Typed records for the page of Table 5. Shares are 0 to 1, times in ms.

A *group* is a scenario, or ``all`` for all cases; mappings by group hold ``all`` first.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.runs.evaluation import Evaluation, LabelledPart
from steadyload.statistics.estimate import Estimate
from steadyload.studies.comparison.summary import AgreementMatrix
from steadyload.studies.table5.paper import Paper


@dataclass(frozen=True, slots=True)
class Timing:
    """Facts on the timing pass besides the times in the rows of the evaluation.

    ``yardstick``: the method that ratios refer to. ``shares``: by group and spec, CPU time over
    that of the yardstick on the same cases; of the methods that were timed, without the yardstick.
    ``spread``: by spec, largest minus smallest mean of a repeat, over the mean. ``untimed``:
    methods without times, with the reason. ``refused``: of methods with times, number of cases that
    they refuse; no method was timed on those.
    """

    yardstick: MethodKey | None
    shares: Mapping[str, Mapping[str, Estimate]]
    spread: Mapping[str, float]
    layouts: int
    item_lists: int
    repeats: int
    block: int
    untimed: Mapping[str, str]
    refused: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class PairTest:
    """Two methods on the same cases: accuracy of the first minus that of the second.

    ``p``: of the sign-flip test over item lists; ``corrected``: by Holm, over all pairs of the
    group.
    """

    first: MethodKey
    second: MethodKey
    difference: Estimate
    p: float
    corrected: float


@dataclass(frozen=True, slots=True)
class PairTests:
    """Pairs of methods in a group: all of them, or each with ``against``.

    ``letters``: by spec; methods that share one are not significantly different at ``level``; empty
    where not all pairs were tested. ``sizes``: cases of every item list, the largest first.
    ``least``: the smallest corrected p that is possible with this number of lists and pairs.
    """

    pairs: tuple[PairTest, ...]
    letters: Mapping[str, str]
    sizes: tuple[int, ...]
    level: float
    least: float
    against: MethodKey | None = None

    def of(self, first: MethodKey, second: MethodKey) -> PairTest:
        """The test of two methods, with the sign reversed where they were tested in reverse order.

        Raises:
            KeyError: these two were not tested.
        """
        for test in self.pairs:
            if (test.first, test.second) == (first, second):
                return test
            if (test.first, test.second) == (second, first):
                d = test.difference
                turned = Estimate(-d.value, -d.high, -d.low, d.n)
                return PairTest(first, second, turned, test.p, test.corrected)
        raise KeyError(first.spec, second.spec)


@dataclass(frozen=True, slots=True)
class SizeBin:
    """Accuracy on layouts in a bin of the number of items: ``accuracy`` by spec."""

    fewest: int
    most: int
    cases: int
    accuracy: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class MarginBin:
    """Steps with a margin of balance in [low, high) cm, and the errors of methods on them.

    ``false_alarms``: by spec, the share of steps stable by the label that fail by the method;
    ``misses``: of those failing by the label that are stable by the method. Only steps that both
    reach are counted. ``holding``, ``failing``: numbers of steps by the labels.
    """

    low: float
    high: float
    holding: int
    failing: int
    false_alarms: Mapping[str, Estimate]
    misses: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class Watch:
    """A robustly labelled case on which methods differ, and two of them to watch side by side.

    ``label``, ``said``: failing steps or ``stable``. ``right``: the most accurate method with the
    label's failing step; ``wrong``: the most accurate one without. ``wrong_methods`` of ``methods``
    are wrong. ``part``: of the labelled set; ``directory``: the word of the set, empty for the
    large one. ``view``: link to the page that plays both loadings; empty without one.
    """

    layout: str
    scenario: str
    item_count: int
    label: str
    right: MethodKey
    wrong: MethodKey
    said: str
    wrong_methods: int
    methods: int
    part: str
    directory: str
    view: str = ""

    @property
    def name(self) -> str:
        """Name of the layout of the case, where cases are written as files."""
        return f"{self.layout}_{self.scenario}"


@dataclass(frozen=True, slots=True)
class CeilingRow:
    """Agreement of the verdicts of an ensemble of references.

    ``judges``: number of further verdicts on a case, besides the label. ``label``: agreement of
    each of them with the label. ``twin``: of two of all verdicts, drawn at random. ``plurality``:
    of one of all verdicts, drawn at random, with the most frequent of the others. The last two are
    None where there is no ensemble.
    """

    name: str
    judges: int
    label: Estimate
    twin: Estimate | None
    plurality: Estimate | None


@dataclass(frozen=True, slots=True)
class Ceiling:
    """Ceiling of the labels.

    ``by_group``: by group, a row a set of changes, from the narrowest to the widest. ``engines``:
    other simulators under the same criterion, on all cases.
    """

    by_group: Mapping[str, tuple[CeilingRow, ...]]
    engines: tuple[CeilingRow, ...]


@dataclass(frozen=True, slots=True)
class Front:
    """Specs of methods than which no cheaper one is as accurate, by rising cost."""

    specs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class JudgedSet:
    """All methods on a part of a labelled set.

    ``tunings``: by spec of a simulation, a text of its parameters; equal for equal parameters.
    ``fronts`` by group; empty where nothing was timed. ``margins`` is empty where the set has none.
    """

    evaluation: Evaluation
    layouts: int
    timing: Timing
    tests: Mapping[str, PairTests]
    tunings: Mapping[str, str]
    fronts: Mapping[str, Front]
    matrix: AgreementMatrix
    sizes: tuple[SizeBin, ...]
    margins: tuple[MarginBin, ...]
    watched: tuple[Watch, ...]

    @property
    def groups(self) -> tuple[str, ...]:
        """All cases, then the scenarios."""
        return self.evaluation.groups

    @property
    def about(self) -> LabelledPart:
        """About the labels of the cases."""
        assert self.evaluation.labelled is not None, "the study is on a labelled set"
        return self.evaluation.labelled


@dataclass(frozen=True, slots=True)
class Table5:
    """All results on the page.

    ``spatial``: 3-D methods; ``planar``: these and 2-D methods on planar layouts, None without 2-D
    methods. ``flat``: number of cases of ``spatial`` that a 2-D engine could judge. ``left_out``:
    by spec, the reason for which a method is in no table.
    """

    spatial: JudgedSet
    planar: JudgedSet | None
    flat: int
    planar_methods: tuple[MethodKey, ...]
    left_out: Mapping[str, str]
    paper: Paper
    ceiling: Ceiling | None
    same_order: tuple[int, int]
    manifest: Mapping[str, str]
