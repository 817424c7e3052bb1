"""Shares of failing plans that stand once they are changed, by way and packer."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace

import numpy as np

from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.sizes import FEWER, SIZES, binned
from steadyload.reports.columns import (
    column,
    general,
    one_decimal,
    percent,
    row,
    significant,
)
from steadyload.runs.labels import made_with
from steadyload.statics.load_margin import CLOSE_CALL
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import mean, ratio, share
from steadyload.studies.packed_plans import PACKER_TITLES
from steadyload.studies.repair.confirming import ENGINES, REFERENCES, SECONDS, SOFT, STIFF
from steadyload.studies.repair.plans import SEARCH_SECONDS, AllTried, Answers, Tried
from steadyload.studies.repair.ways import Way

ALL = "all"
"""Plans of all packers together, each once."""

GROUPS = ("repaired plans", "controls")
"""Plans that independent judges judge."""

FIRM = 0.95
"""A plan with at least this chance to stand stands firmly."""


@row
class Shares:
    """Plans of a packer, changed in a way; amounts are of those that stand then.

    Amounts that are not known of a way are None.
    """

    packer: str = column()
    way: Way = column(left=True)
    plans: int = column("n")
    stands: Estimate = column("stand %", percent, "of all, by the judge")
    whole: Estimate = column("stand, none left out %", percent, "of all")
    boxes_out: Estimate = column("boxes left out %", percent)
    volume_out: Estimate = column("volume left out %", percent)
    moved_median: float | None = column("boxes moved, median", general)
    moved: Estimate | None = column("boxes moved, mean", one_decimal)
    distance_cm: Estimate | None = column("moved by cm", one_decimal, "a moved box, on average")
    retimed: Estimate | None = column("loaded at another time", one_decimal, "boxes, mean")
    unchanged: int = column("stood before", about="by the judge, against the label")
    timeouts: int = column("out of time", about="searches that the time limit ended")

    @property
    def failed(self) -> int:
        """Plans that the judge sees fail."""
        return self.plans - self.unchanged

    @property
    def repaired(self) -> int:
        """Of these the plans that stand then."""
        return round(self.stands.value * self.plans)


@row
class Cost:
    """CPU time of a way on plans of a size."""

    boxes_of: str = column("boxes", left=False)
    way: Way = column(left=True)
    plans: int = column("n")
    median_s: float = column("CPU s, median", significant)
    most_s: float = column("90 % at most s", significant)
    worst_s: float = column("worst s", significant)


@row
class Independent:
    """Plans that were repaired, boxes left out where that helps, and controls, by a judge that took
    no part; no answer is no yes.
    """

    judge: str = column()
    plans: int = column("repaired n")
    stands: Estimate = column("stand %", percent)
    unknown: int = column("no answer")
    control_plans: int = column("controls n")
    control_stands: Estimate = column("stand %", percent)
    control_unknown: int = column("no answer")


@row
class Firm:
    """Margins of plans, and chances to stand where each centre of mass is off by 5 mm (s.d.)."""

    which: str = column("plans")
    plans: int = column("n")
    as_planned: int = column("balance as planned", about="n; what follows is of these")
    margin_cm: float | None = column("margin cm, median", significant)
    close: Estimate = column("below 1 cm %", percent)
    chance: Estimate = column("chance to stand %", percent, "on average")
    firm: Estimate = column("chance 95 % or more %", percent)


@row
class Until:
    """Shares [%] by which plans are changed until they stand, ascending, of all plans of a way."""

    way: Way
    out: Sequence[float]
    moved: Sequence[float]
    plans: int


class Found(SimpleNamespace):
    """All that the page shows."""

    shares: Sequence[Shares]
    costs: Sequence[Cost]
    independent: Sequence[Independent]
    firm: Sequence[Firm]
    until: Sequence[Until]
    tried: Sequence[Tried]
    leave: Shares
    keep: Shares
    by_reference: Independent | None
    all: Sequence[Shares]
    by_packer: Sequence[Shares]
    moving: Sequence[Until]
    made_with: Mapping[str, str]


def summarise(benchmark: Benchmark, found: AllTried) -> Found:
    """Shares and amounts by way and packer; every interval resamples published instances."""
    tried, answers = found.tried, found.answers
    groups = [[one for one in answers if one.repaired is repaired] for repaired in (True, False)]
    sizes = [len(one.plan.layout) for one in tried]
    shares = [_shares(*each) for each in _groups(tried)]
    together = {each.way: each for each in shares if each.packer == ALL}
    until = [_until(way, own) for packer, way, own in _groups(tried) if packer == ALL]
    most_out = max((share for each in until for share in each.out), default=0.0)
    independent = [_independent(title, *groups) for title in (*ENGINES, *REFERENCES)]
    return Found(
        plans=len({one.plan.layout.name for one in tried}),
        labelled=found.labelled,
        instances=len({one.plan.instance for one in tried}),
        fewest=min(sizes),
        most=max(sizes),
        judges=list(dict.fromkeys(one.changed.judge for one in tried)),
        all=list(together.values()),
        by_packer=[each for each in shares if each.packer != ALL],
        shares=shares,
        leave=together[Way.LEAVE],
        keep=together[Way.KEEP],
        costs=list(_costs(tried, sizes)),
        independent=independent,
        by_reference=next((one for one in independent if one.judge == STIFF and one.plans), None),
        firm=[_firm(which, own) for which, own in zip(GROUPS, groups, strict=True) if own],
        soft=_soft(groups[0]),
        soft_controls=_soft(groups[1]),
        unfinished=sum(len(one.references) < len(REFERENCES) for one in answers),
        until=until,
        moving=[each for each in until if each.way is not Way.AGAIN],
        most_out=(0.0, 10.0 * (1 + most_out // 10)),
        not_installed=found.not_installed,
        search_s=SEARCH_SECONDS,
        seconds=SECONDS,
        made_with={**made_with(benchmark), **found.made_with},
        tried=tried,
    )


def _standing(tried: Sequence[Tried]) -> list[Tried]:
    return [one for one in tried if one.changed.stands]


def _groups(tried: Sequence[Tried]) -> Iterator[tuple[str, Way, list[Tried]]]:
    """By packer, all first, and way; empty groups are left out."""
    for packer in (ALL, *PACKER_TITLES.values()):
        for way in Way:
            own = [
                one
                for one in tried
                if one.way is way and (packer == ALL or packer in one.plan.packers)
            ]
            if own:
                yield packer, way, own


def _lists(tried: Sequence[Tried]) -> list[str]:
    return [one.plan.instance for one in tried]


def _shares(packer: str, way: Way, own: list[Tried]) -> Shares:
    lists, standing = _lists(own), _standing(own)
    of_standing = _lists(standing)
    changed = [one.changed for one in standing]
    boxes = [len(one.plan.layout) for one in standing]
    volumes = [float(one.plan.layout.sizes.prod(axis=1).sum()) for one in standing]
    moved = [one.moved for one in changed if one.moved is not None]
    known = len(moved) == len(changed) and bool(changed)
    far = [one.distance_cm or 0.0 for one in changed]
    out = [one.volume_left_out * volume for one, volume in zip(changed, volumes, strict=True)]
    return Shares(
        packer=packer,
        way=way,
        plans=len(own),
        stands=share([one.changed.stands for one in own], lists),
        whole=share([one.changed.stands and not one.changed.left_out for one in own], lists),
        boxes_out=ratio([one.left_out for one in changed], boxes, of_standing),
        volume_out=ratio(out, volumes, of_standing),
        moved_median=float(np.median(moved)) if known else None,
        moved=mean(moved, of_standing) if known else None,
        distance_cm=_far(far, moved, of_standing) if known else None,
        retimed=mean([one.retimed or 0 for one in changed], of_standing) if known else None,
        unchanged=sum(one.changed.outcome == "unchanged" for one in own),
        timeouts=sum(one.changed.stopped == "time" for one in own),
    )


def _far(far: list[float], moved: list[int], lists: list[str]) -> Estimate:
    """Distance of a moved box, on average over the plans in which one is moved."""
    some = [k for k, count in enumerate(moved) if count]
    if not some:
        return NOTHING
    return ratio([far[k] for k in some], [moved[k] for k in some], [lists[k] for k in some])


def _costs(tried: Sequence[Tried], sizes: Sequence[int]) -> Iterator[Cost]:
    place, names = binned(sizes, (FEWER, *SIZES))
    bins = {ALL: list(tried)} | {
        name: [one for one, at in zip(tried, place, strict=True) if at == number]
        for number, name in names.items()
    }
    for name, members in bins.items():
        for packer, way, own in _groups(members):
            if packer == ALL:
                seconds = [one.changed.seconds for one in own]
                yield Cost(
                    name, way, len(own), float(np.median(seconds)),
                    float(np.quantile(seconds, 0.9)), max(seconds),
                )  # fmt: skip


def _independent(title: str, repaired: Sequence[Answers], others: Sequence[Answers]) -> Independent:
    own, control = (
        [(said, one.plan.instance) for one in group
         if (said := {**one.engines, **one.references}.get(title)) is not None]
        for group in (repaired, others)
    )  # fmt: skip
    values = [
        (len(group), share([said.stands for said, _ in group], [each for _, each in group]),
         sum(not said.is_known for said, _ in group))
        for group in (own, control)
    ]  # fmt: skip
    return Independent(title, *values[0], *values[1])


def _firm(which: str, own: Sequence[Answers]) -> Firm:
    planned = [one for one in own if one.firmness.as_planned]
    lists = [one.plan.instance for one in planned]
    margins = [one.firmness.margin_cm or 0.0 for one in planned]
    chances = [one.firmness.chance for one in planned]
    return Firm(
        which=which,
        plans=len(own),
        as_planned=len(planned),
        margin_cm=float(np.median(margins)) if planned else None,
        close=share([margin < CLOSE_CALL for margin in margins], lists),
        chance=mean(chances, lists),
        firm=share([chance >= FIRM for chance in chances], lists),
    )


def _soft(own: Sequence[Answers]) -> Estimate:
    """Plans that fall by the softer reference, of those that stand by the stiffer one."""
    both = [one for one in own if len(one.references) == len(REFERENCES)]
    stood = [one for one in both if one.references[STIFF].stands]
    return share(
        [not one.references[SOFT].stands for one in stood], [one.plan.instance for one in stood]
    )


def _until(way: Way, own: list[Tried]) -> Until:
    standing = [(one.changed, len(one.plan.layout)) for one in _standing(own)]
    return Until(
        way,
        sorted(100.0 * changed.left_out / boxes for changed, boxes in standing),
        sorted(100.0 * (changed.moved or 0) / boxes for changed, boxes in standing),
        len(own),
    )


COLUMNS = (
    "packers", "plan", "boxes", "way", "outcome", "judge", "failing_step_before", "boxes_left_out",
    "volume_left_out_share", "boxes_moved", "distance_cm", "boxes_loaded_at_another_time",
    "order_alone", "cpu_s", "stopped",
)  # fmt: skip
"""Header of the file of all plans."""


def as_csv(tried: Sequence[Tried]) -> str:
    """All plans in all ways, a line each; what is not known is empty."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(COLUMNS)
    for one in tried:
        changed = one.changed
        values = [
            "; ".join(one.plan.packers), changed.plan, len(one.plan.layout), changed.way,
            changed.outcome, changed.judge, changed.step_before,
            *(
                (changed.left_out, f"{changed.volume_left_out:.4f}")
                if changed.stands
                else (None, None)
            ),
            changed.moved,
            None if changed.distance_cm is None else f"{changed.distance_cm:.1f}",
            changed.retimed, changed.by_order_alone if changed.stands else None,
            f"{changed.seconds:.3f}", changed.stopped,
        ]  # fmt: skip
        lines.writerow(["" if value is None else value for value in values])
    return text.getvalue()
