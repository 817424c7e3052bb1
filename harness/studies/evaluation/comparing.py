"""All that pages of the study show: for every question frames of methods, of cases, and of tests.

A *group* is a scenario, or ``all`` for all cases. Shares are 0 to 1, times in ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import permutations
from pathlib import Path
from types import SimpleNamespace

import pandas as pd

from steadyload.app.recommend.kept import NAME, SMALL, load_fronts, merged, write_fronts
from steadyload.app.recommend.measured import front_of
from steadyload.labelling.ceiling import Ceiling, label_ceiling
from steadyload.labelling.screened import (
    CheckedScreening,
    ScreenedSteps,
    checked_screening,
    screened_steps,
)
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import PLANAR
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.learners.weights import load_weights
from steadyload.methods.contract.declared import Trait
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import planar_scene
from steadyload.reports import frame_points, frames
from steadyload.runs import frames as v
from steadyload.runs.answers import Answers, answers_of, judged_layouts, listed_cases
from steadyload.runs.costs import timed_costs
from steadyload.runs.evaluation import ALL, labelled_part
from steadyload.runs.judged import JudgedCases, manifest_lines
from steadyload.runs.labels import statuses_on
from steadyload.runs.paper import paper
from steadyload.runs.results import kept_layouts, load_results
from steadyload.runs.timing import BLOCK
from steadyload.statistics.metrics import agreement, share
from steadyload.studies.agreement_section import answer_chart
from steadyload.studies.evaluation import methods, places
from steadyload.studies.evaluation.floors import floors
from steadyload.studies.evaluation.judging import Options, Ran, Timed, judged_and_timed
from steadyload.studies.evaluation.methods import LINES, Values
from steadyload.studies.evaluation.verdicts import (
    UNIT,
    YARDSTICK,
    binned_by_boxes,
    costed,
    with_origins,
)
from steadyload.studies.evaluation.watched import watched
from steadyload.studies.kit import Lab

_CONVERTED = frozenset({"ps3", "ps5"})


class Found(SimpleNamespace):
    """All that the page shows; ``sets`` and ``planar`` hold the same names for a question each."""

    made_with: Mapping[str, str]
    ceiling: Ceiling | None
    screened: ScreenedSteps
    checked: Sequence[CheckedScreening]


def compare(lab: Lab, asked: Options) -> Found:
    """Judge and time what is missing, and compare; also writes what ``recommend`` reads."""
    ran = judged_and_timed(lab, asked)
    main, *_ = ran.values()
    benchmark = load_benchmark(main.definition.benchmark_directory)
    every = main.judged()
    labelled = [q for q in asked.questions if len(every.asked(q).said)] or asked.questions[:1]
    sets = [of_question(asked, ran, every, benchmark, question) for question in labelled]
    own, first = sets[0], asked.questions[0]
    planar = of_planar(asked, ran[PLANAR]) if PLANAR in ran else None
    made_with = manifest_lines(own["judged"])
    if main.timed:
        made_with |= {f"times: {k}": of for k, of in main.timed.times.made_with.items()}
    if planar:
        lines = manifest_lines(planar["judged"])
        made_with |= {f"planar {key}": lines[key] for key in ("labelled set", "layouts", "rows")}
    keys = {spec: key for one in sets for spec, key in one["keys"].items()}
    apart = set().union(*(one["judged"].apart for one in sets))
    papers = Question.WITHIN in asked.questions and asked.timeout is None
    epochs, converted = unlike_the_paper(list(own["keys"].values()))
    answered = benchmark.cases["status"].value_counts().sort_index()
    for one in sets if asked.published is None else ():
        _write_front(one, main.timed, made_with, lab.work)
    return Found(
        made_with=made_with,
        sets=sets,
        planar=planar,
        planar_methods=[method_key(make_method(spec)).title for spec in asked.planar],
        flat=_flat(every, benchmark) if planar else 0,
        left_out=asked.left_out,
        epochs=epochs if papers else None,
        converted=converted and papers,
        ceiling=label_ceiling(
            labels_of(every.asked(first)), benchmark.further_verdicts_on(first), first
        ),
        small=SMALL in ran,
        lost=without_verdict([own for one in ran.values() for own in one.folders], keys),
        who_planned=places.who_planned({one["question"]: one["frame"] for one in sets}),
        floors=floors(lab, asked, benchmark),
        screened=screened_steps(benchmark.screening),
        checked=checked_screening(benchmark.screening, benchmark.cases),
        fails=pd.concat([_failing(one["judged"], one["question"], benchmark) for one in sets]),
        unlabelled={str(k): int(n) for k, n in answered.items() if k != "done"},
        screens=own["judged"].screens,
        apart=[key for spec, key in keys.items() if spec in apart],
        screened_above=MOST_SMALL,
    )  # fmt: skip


def of_question(
    asked: Options,
    ran: Mapping[str, Ran],
    every: JudgedCases,
    benchmark: Benchmark,
    question: Question,
) -> Values:
    """All that the page shows for a question."""
    main, *_ = ran.values()
    judged = every.of(asked.shown(question)).asked(question)
    judged = judged.with_confidence(benchmark.confidence_on(question))
    limited = asked.timeout is not None
    frame = costed(judged, main, asked)
    frame = with_origins(frame, benchmark) if limited else frame.assign(origin=None)
    found = _common(judged, frame, main, question)
    rows, tests = found["rows"], found["tests"]
    whole = frame
    if SMALL in ran:
        small = ran[SMALL].judged().of(judged.keys).asked(question)
        whole = pd.concat([costed(small, ran[SMALL], asked), frame])
    if limited:
        rows["exponent"] = methods.exponents(frame)
        rows["exponent_of_all"] = methods.exponents(whole)
    on_front = v.front(*(rows.loc[found["compared"], name] for name in ("right", "cpu")))
    best_last = v.values(rows.loc[on_front, "right"]).sort_values(kind="stable")
    lines = list(best_last.index[-LINES:])
    binned, of_set = (binned_by_boxes(one, real=limited) for one in (whole, frame))
    by_boxes = places.by_boxes(binned, rows, lines)
    parts = places.origins(of_set)
    own_spans = places.spans(frame) if limited else []
    lost = statuses_on(labels_of(every), question).drop(judged.said.index).fillna("not asked")
    printed = paper() if not limited and question == Question.WITHIN else None
    margin = benchmark.cases.set_index(KEYS).loc[judged.said.index, "margin"]
    held = [YARDSTICK] if main.timed and YARDSTICK in main.timed.times.cpu else []
    found |= {
        "charted": found["charted"] | {
            part["name"]: frames.records(part["rows"]) for part in (*parts, *own_spans)
        },
        "without_label": {str(k): int(n) for k, n in lost.value_counts().items()},
        "spans": _spans_table(own_spans),
        "origins": parts,
        "origin_bins": pd.concat([
            by_boxes["bins"].assign(origin="all cases"), *(part["bins"] for part in parts)
        ]),
        "falls": (fallen := places.falls(frame, rows)),
        "fallen_of": next((c.partition(":")[2] for c in fallen if c.startswith("found:")), ""),
        "by_class": places.by_class(frame, rows),
        **by_boxes,
        **(places.costs_by_boxes(binned, by_boxes["bins"], of_set, rows, lines)
           if limited else {"size_costs": {}, "cost_curve": []}),
        **methods.error_costs(rows.loc[found["compared"]]),
        "against": {
            rows["title"][one]: methods.against(tests, rows, one)
            for one in dict.fromkeys((*held, found["best"]))
        },
        "differences": methods.differences(tests[ALL], rows, found["few"]),
        **methods.engines_and_tunings(tests[ALL], judged.keys),
        "crossed": methods.crossed(frame, rows, found["few"]),
        **places.margins(frame, margin, rows, found["few"]),
        "agreement": _agreement(judged, found["few"]),
        "answer_chart": answer_chart(
            {spec: key.title for spec, key in judged.keys.items()}, _answers(judged, main)
        ),
        **watched(v.comparable(frame), rows, main.definition),
        **(methods.beside_paper(found["groups"], printed) if printed else {"printed": None}),
    }  # fmt: skip
    return found


def of_planar(asked: Options, ran: Ran) -> Values:
    """All methods on planar layouts, each compared with one alone: the item lists are few."""
    judged = ran.judged().of((*asked.shown(Question.WITHIN), *asked.planar))
    frame = costed(judged.asked(Question.WITHIN), ran, asked)
    found = _common(judged, frame, ran, Question.WITHIN, against=YARDSTICK)
    rows, tests = found["rows"], found["tests"][ALL]
    right = v.share(frame.sort_values("scenario", kind="stable"), "right", ["method", "scenario"])
    found["rows"] = rows.join(tests.droplevel("second")[["difference", "corrected"]]).join(
        frames.across(right, "scenario", "scenario_right")
    )
    against = tests.index.get_level_values("second")[0] if len(tests) else found["best"]
    return found | {"held": rows["title"][against]}


def _common(
    judged: JudgedCases, frame: pd.DataFrame, ran: Ran, question: Question, against: str = ""
) -> Values:
    """All that is shown of every set: rows of methods, tests, and numbers of cases.

    Others are compared with ``against`` alone; with no such method in all pairs.
    """
    part = labelled_part(judged)
    compared = list(v.comparable(frame)["method"].unique())
    rows = methods.every_method(frame, part.natural_stable)
    best = v.best(rows.loc[compared, "right"])
    held = against if against in judged.keys else best
    pairs = [(m, held) for m in rows.index if m != held] if against else None
    printed, groups, tests = paper(), {}, {}
    for group, cases in v.grouped(frame).groupby("group", sort=False):
        groups[group] = own = rows if group == ALL else methods.by_method(cases)
        tests[group] = v.pairs(cases[cases["method"].isin(compared)], chosen=pairs)
        if not against:
            own["letters"] = v.letters(tests[group], own.loc[compared, "right"])
        like = [printed.like(key) for key in own["key"]]
        own["paper"] = [one and one.accuracy.get(group) for one in like]
        if group != ALL:
            rows[f"scenario_cpu:{group}"] = v.values(own["cpu"].dropna())
    few = methods.chosen_few(rows.loc[compared])
    titles = {group: "all scenarios" if group == ALL else group for group in groups}
    return asdict(part) | {
        "judged": judged, "frame": frame, "question": question, "keys": judged.keys,
        "rows": rows, "groups": groups, "compared": compared, "best": best,
        **methods.leaders(rows.loc[compared]),
        "tests": tests, "family": _family(tests[ALL], part.item_lists),
        "few": few, "few_rows": frames.records(rows, few),
        "charted": {titles[group]: frames.records(own) for group, own in groups.items()},
        "alike": {} if against else methods.alike(v.versus(tests[ALL], best), rows["title"]),
        "layouts": judged.results["layout"].nunique(),
        "stable_share": places.stable_share(frame),
        "timing": _timing(ran.timed, judged) if ran.timed else None,
        "yardstick": rows["title"].get(YARDSTICK) if ran.timed else None,
    }  # fmt: skip


def labels_of(judged: JudgedCases) -> pd.DataFrame:
    """The labels of cases of a labelled set."""
    assert judged.labels is not None, "the study is on a labelled set"
    return judged.labels


def _family(tests: pd.DataFrame, clusters: int) -> Values:
    """Number of tests and item lists, and the smallest corrected p that these can give."""
    least = min(1.0, len(tests) * 2.0 ** (1 - clusters))
    return {"tests": len(tests), "clusters": clusters, "least": least}


def _timing(timed: Timed, judged: JudgedCases) -> Values:
    """The timing pass besides the times of methods."""
    own = timed.among(judged.said.index)
    cases = pd.MultiIndex.from_tuples(own.cases, names=KEYS)
    source = timed_costs(own.times, cases).source
    unit = judged.keys[UNIT].title if UNIT in own.times.cpu and UNIT in judged.keys else None
    return {
        "explained": source.explained(), "load": source.load, "unit": unit, "block": BLOCK,
        "layouts": len(cases), "lists": judged.clusters.loc[cases].nunique(),
        "untimed": own.untimed, "refused": own.refused,
    }  # fmt: skip


def _spans_table(found: Sequence[Values]) -> pd.DataFrame:
    """Of every size, its most accurate method, and the cheapest within one point of it."""
    return pd.DataFrame([
        {"size": one["name"], "cases": one["cases"], "stable": one["stable"],
         "title": one["leading"]["title"], "right": one["leading"]["right"],
         "median": one["leading"]["median"],
         **({} if one["cheap"] is None else
            {"cheap": one["cheap"]["title"], "cheap_right": one["cheap"]["right"],
             "cheap_median": one["cheap"]["median"]})}
        for one in found
    ])  # fmt: skip


def _agreement(judged: JudgedCases, few: Sequence[str]) -> list[Values]:
    """Cells of a matrix: how often two of the few methods name the same step."""
    found = {
        (one, other): agreement(judged.said, one, other, judged.clusters)
        for one, other in permutations(few, 2)
    }
    titles = {spec: judged.keys[spec].title for spec in few}
    return frame_points.cells(pd.Series(found, dtype=object), titles, titles)


def _answers(judged: JudgedCases, ran: Ran) -> Answers | None:
    kept = kept_layouts(ran.folder)
    return answers_of(judged, judged_layouts(judged, kept, listed_cases(judged)))


def _failing(judged: JudgedCases, question: Question, benchmark: Benchmark) -> pd.DataFrame:
    """Shares of cases whose label is a failing step, of a page and of its set."""
    own, whole = labels_of(judged), benchmark.select(question=question)
    shares = [share(own["failing_step"].notna(), judged.clusters),
              share(whole["failing_step"].notna(), whole["instance"])]  # fmt: skip
    titles = [f"{question}, the cases of this page", f"{question}, the whole set"]
    return pd.DataFrame({"case_label": titles, "fails": shares})


def without_verdict(folders: Sequence[Path], keys: Mapping[str, MethodKey]) -> pd.DataFrame:
    """Cases without a verdict by method and status, over all runs."""
    columns = ("layout", "scenario", "method", "method_name", "engine", "repetition", "status",
               "reason", "item_count")  # fmt: skip
    rows = pd.concat([load_results(folder, columns) for folder in folders], ignore_index=True)
    rows = rows[(rows["status"] != "done") & (rows["repetition"] == 0)]
    return pd.DataFrame([
        {"title": keys[str(spec)].title, "status": str(status), "cases": len(own),
         "boxes": f"{own['item_count'].min()} to {own['item_count'].max()}",
         "reason": str(own.loc[own["item_count"].idxmax(), "reason"])}
        for (spec, status), own in rows.groupby(["method", "status"], sort=False)
        if spec in keys
    ])  # fmt: skip


def unlike_the_paper(methods: Sequence[MethodKey]) -> tuple[tuple[int, int, int] | None, bool]:
    """Traits of some methods that the paper's of their names have not.

    Returns:
        Least and most epochs of the networks that learnt what the paper's are told, and those that
        were asked for, None where no learned method is among the paper's; whether PS_3 or PS_5 are
        there in a reading converted to SI.
    """
    theirs = [key for key in methods if paper().row_of(key)]
    converted = any(key.family in _CONVERTED for key in theirs)
    if not any(Trait.LEARNED in make_method(key.spec).traits for key in theirs):
        return None, converted
    members = load_weights("lstm_e-paper").manifest["members"]
    epochs = [member["epochs"] for member in members]
    return (min(epochs), max(epochs), members[0]["options"]["epochs"]), converted


def _flat(judged: JudgedCases, benchmark: Benchmark) -> int:
    """Cases that an engine of two dimensions could judge."""
    layouts = (benchmark.layout(name, scenario) for name, scenario in judged.said.index)
    return sum(planar_scene(layout).across is not None for layout in layouts)


def _write_front(
    own: Values, timed: Timed | None, made_with: Mapping[str, str], work: Path
) -> None:
    """Write what ``recommend`` reads to a work folder, beside what it holds of another question.

    Without a timing pass nothing is written; methods without times are left out.
    """
    if timed is None:
        return
    file, count = work / NAME, own["timing"]["layouts"]
    about = {**made_with, **timed.times.made_with}  # the machine is that of the times
    times = f"mean of {count} cases, one thread"
    new = front_of(own["judged"], own["question"], own["rows"], times, about)
    write_fronts(merged(load_fronts(file) if file.exists() else (), [new]), file)
