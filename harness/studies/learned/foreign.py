"""Learned methods on layouts of another kind than those of their training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import combinations
from operator import attrgetter
from pathlib import Path

from steadyload.learners.methods import LearnedMethod
from steadyload.learners.plans.plan import ForeignPlan
from steadyload.learners.ranges import QUANTITIES, extents_of
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, percent, row
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import MethodEvaluation, evaluate
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, share
from steadyload.studies.kit import Lab

_ends = "{0[0]:g} to {0[1]:g}".format


@row
class Agreeing:
    """Share of equal failing steps, of two methods or sources of labels."""

    what: str = column()
    same: Estimate = column("same failing step %", percent)


@row
class Reason:
    """A quantity that is outside of the training range; a layout may have several."""

    judge: str = column()
    quantity: str = column("outside")
    layouts: int = column()
    trained: tuple[float, float] = column("trained on", _ends)
    here: tuple[float, float] = column(form=_ends, about="of all layouts")


@row
class Judged:
    """A learned method, which refuses layouts outside of its training range."""

    method: MethodKey = column("judge", attrgetter("title"), left=True)
    refused: Estimate = column("refused %", percent)
    agreement: Mapping[str, Estimate] = column(
        "as {} %", percent, "share of equal failing steps, with refusals switched off"
    )
    accepting: MethodEvaluation
    accepted: int = column("n", about="layouts that it does not refuse")
    inside: Mapping[str, Estimate] = column("as {} %", percent, "share of equal steps on these")


@row
class Foreign:
    """Layouts of another kind; ``among``: agreement of the other methods two by two."""

    files: int
    layouts: int
    max_items: int
    rows: Sequence[Judged]
    reasons: Sequence[Reason]
    others: Sequence[MethodEvaluation]
    among: Sequence[Agreeing]


def judge_foreign(lab: Lab, plan: ForeignPlan, files: Sequence[Path], limit: int | None) -> Foreign:
    """Share of layouts that learned methods refuse, and their agreement with other methods."""
    accepting = {
        spec: str(make_method(str(make_method(spec).spec.stating("outside", "accept"))).spec)
        for spec in plan.judges
    }
    study = StudyDefinition(
        name="learned foreign",
        methods=(*plan.others, *accepting.values()),
        files=tuple(file.resolve() for file in files),
        max_items=plan.max_items,
        limit=limit,
        shard_size=60,
    )
    run = lab.work / "foreign"
    run_study(study, run, workers=lab.workers, progress=partial(lab.progress, "foreign"))
    evaluation = evaluate(run, by_scenario=False)
    said = evaluation.judged.said
    others = [evaluation.row(str(make_method(spec).spec)) for spec in plan.others]
    keys = [each.method for each in others]
    every = {each.name: each.first(min(len(each), plan.max_items)) for each in study.layouts()}
    layouts = [every[name] for name in said.index.get_level_values("layout")]
    extents = extents_of(layouts)
    here = list(zip(extents[:, 0].min(axis=0), extents[:, 1].max(axis=0), strict=True))
    reasons = []

    def judged(spec: str) -> Judged:
        judge = make_method(spec)
        assert isinstance(judge, LearnedMethod)
        key, ranges, own = method_key(judge), judge.weights.ranges, accepting[spec]
        beyond = ranges.beyond(extents)
        inside = said[~beyond.any(axis=1)]
        counts = zip(QUANTITIES, beyond.sum(axis=0).tolist(), here, strict=True)
        found = [Reason(key.title, q, n, ranges.ranges[q], ends) for q, n, ends in counts if n]
        reasons.extend(sorted(found, key=lambda reason: -reason.layouts))
        return Judged(
            method=key,
            refused=share(beyond.any(axis=1)),
            agreement={o.title: agreement(said, own, o.spec) for o in keys},
            accepting=evaluation.row(own),
            accepted=len(inside),
            inside={o.title: agreement(inside, own, o.spec) for o in keys},
        )

    return Foreign(
        files=len(study.files),
        layouts=len(layouts),
        max_items=plan.max_items,
        rows=[judged(spec) for spec in plan.judges],
        reasons=reasons,
        others=others,
        among=[
            Agreeing(f"{one.title} and {two.title}", agreement(said, one.spec, two.spec))
            for one, two in combinations(keys, 2)
        ],
    )
