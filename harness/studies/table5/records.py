"""What the page of Table 5 shows, as small typed records. Shares from 0 to 1, times in ms.

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
    """How the timing pass was made, beside the times in the rows of the evaluation.

    ``yardstick``: the method that ratios are to. ``shares``: by group and spec, CPU time over that
    of the yardstick on the same cases; of the methods that were timed, without the yardstick.
    ``spread``: by spec, largest minus smallest mean of a repeat, over the mean. ``untimed``:
    methods without times, and why. ``refused``: of methods with times, cases that they refuse;
    nobody was timed on those.
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

    ``letters``: by spec; methods that share one are not told apart at ``level``; empty where not
    all pairs were tested. ``sizes``: cases of every item list, the largest first. ``least``: the
    smallest corrected p that so many lists and pairs can give.
    """

    pairs: tuple[PairTest, ...]
    letters: Mapping[str, str]
    sizes: tuple[int, ...]
    level: float
    least: float
    against: MethodKey | None = None

    def of(self, first: MethodKey, second: MethodKey) -> PairTest:
        """The test of two methods, turned round where it was made the other way.

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
    """Accuracy on layouts of so many items: ``accuracy`` by spec."""

    fewest: int
    most: int
    cases: int
    accuracy: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class MarginBin:
    """Steps whose balance has a margin in [low, high) cm, and what methods make of them.

    ``false_alarms``: by spec, the share of steps that hold by the label and fail by the method;
    ``misses``: of those that fail by the label and hold by the method. Only steps that both come to
    are counted. ``holding``, ``failing``: steps of the labels.
    """

    low: float
    high: float
    holding: int
    failing: int
    false_alarms: Mapping[str, Estimate]
    misses: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class Watch:
    """A robustly labelled case on which methods part, and two of them to watch side by side.

    ``label``, ``said``: failing steps or ``stable``. ``right``: the most accurate method that names
    the label; ``wrong``: the most accurate one that does not. ``wrong_methods`` of ``methods`` do
    not. ``part``: of the labelled set; ``directory``: the word of the set, empty for the large one.
    ``view``: the page that plays both loadings, as this page may link it; empty without one.
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
        """Of the case as a layout, where cases are written as files."""
        return f"{self.layout}_{self.scenario}"


@dataclass(frozen=True, slots=True)
class CeilingRow:
    """How often answers to the same question agree that were found otherwise.

    ``judges``: how many further answers a case has, besides the label. ``label``: each of them
    against the label. ``twin``: two of all answers, drawn at random, against each other.
    ``plurality``: one of all answers, drawn at random, against the most frequent of the others.
    The last two are None where there are no draws to compare.
    """

    name: str
    judges: int
    label: Estimate
    twin: Estimate | None
    plurality: Estimate | None


@dataclass(frozen=True, slots=True)
class Ceiling:
    """What the labels' own noise leaves to be reached.

    ``by_group``: by group, a row a set of changes, from the narrowest to the widest. ``engines``:
    other simulators that were asked the same question, all cases.
    """

    by_group: Mapping[str, tuple[CeilingRow, ...]]
    engines: tuple[CeilingRow, ...]


@dataclass(frozen=True, slots=True)
class Front:
    """Specs of methods that no other is as accurate as at a lower cost, by rising cost."""

    specs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class JudgedSet:
    """All methods on a part of a labelled set.

    ``tunings``: by spec of a simulation, a text of its parameters; those of one text share them.
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
    """The whole page.

    ``spatial``: methods in space; ``planar``: those of two dimensions beside them on layouts that
    they can judge, None where none was asked for. ``flat``: cases of ``spatial`` that a planar
    engine could judge. ``left_out``: by spec, why a method is in no table.
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
