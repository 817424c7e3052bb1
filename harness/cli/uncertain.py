"""``steadyload score --uncertain`` and ``steadyload uncertain``: how sure verdicts are."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, progress_bar, resumable
from steadyload.methods.spec import SpecError, bind
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.runs.outlook import Ending, Sampling

_SHOWN = 3
"""Failing steps in a cell, the most probable first."""


def add_uncertainty(score: argparse.ArgumentParser) -> None:
    """Add what asks how sure a verdict is."""
    score.add_argument(
        "--uncertain", metavar="WHAT",
        help="how probable it is that the load stands when it deviates from its plan by, for "
        "example, com=5mm,position=3mm,weight=5%%,friction=0.1 (standard deviations)",
    )  # fmt: skip
    score.add_argument(
        "--half-width", metavar="W",
        help="with --uncertain: sample until the probability is known to W (default: 0.05)",
    )  # fmt: skip
    score.add_argument(
        "--decide", metavar="P",
        help="with --uncertain: or until it is known to lie above or below P",
    )  # fmt: skip
    score.add_argument(
        "--samples", type=at_least(1), metavar="N",
        help="with --uncertain: at most so many, 64 times a power of two (default: 1024)",
    )  # fmt: skip


def asked_for(options: argparse.Namespace) -> dict[str, Any]:
    """What is uncertain and how long to sample, as arguments of a score; none if it was not asked.

    Raises:
        SpecError: not of the form, out of range, or an option that needs ``--uncertain``.
    """
    given = {"half_width": options.half_width, "decide": options.decide, "most": options.samples}
    values = {key: value for key, value in given.items() if value is not None}
    if options.uncertain is None:
        if values:
            raise SpecError("--half-width, --decide and --samples need --uncertain")
        return {}
    sampling = bind(Sampling, {**values, "seed": options.seed}, where="sampling")
    return {"uncertainty": parse_uncertainty(options.uncertain), "sampling": sampling}


def without_effect(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """A sentence for each method to which something uncertain means nothing."""
    found = {
        record["method"]: record["uncertain"]["without_effect"]
        for record in records
        if record.get("uncertain")
    }
    return [
        f"{method}: has no parameter {' and '.join(names)}; that it is uncertain has no effect"
        for method, names in found.items()
        if names
    ]


def uncertain_table(
    records: Iterable[Mapping[str, Any]],
) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Header and rows for people."""
    header = (
        "layout", "method", "items", "score", "failing step", "stands %", "fails at",
        "expected score", "samples", "seconds", "why",
    )  # fmt: skip
    return header, [_row(record, record["uncertain"]) for record in records]


def _row(record: Mapping[str, Any], found: Mapping[str, Any] | None) -> tuple[str, ...]:
    items, score, step = (record[key] for key in ("items", "score", "failing_step"))
    plan = (
        record["layout"],
        record["method"],
        "-" if items is None else str(items),
        record["status"] if score is None else f"{score:.3f}",
        "-" if step is None else str(step),
    )
    if found is None or found["stands"] is None:
        return (*plan, "-", "-", "-", "-", "-", record["reason"])
    low, high = (100.0 * end for end in found["interval"])
    return (
        *plan,
        f"{100.0 * found['stands']:.1f} [{low:.1f}, {high:.1f}]",
        _distribution(found["distribution"]),
        f"{found['expected_score']:.3f}",
        str(found["samples"]),
        f"{found['seconds']:.2f}",
        "; ".join(filter(None, (record["reason"], _shortage(found)))),
    )


def _distribution(shares: Mapping[str, float]) -> str:
    order = sorted(shares.items(), key=lambda entry: -entry[1])
    more = ", ..." if len(order) > _SHOWN else ""
    return ", ".join(f"{step} ({100.0 * share:.0f} %)" for step, share in order[:_SHOWN]) + more


def _shortage(found: Mapping[str, Any]) -> str:
    """Why an interval says less than was asked for."""
    lost = ", ".join(f"{count} {status}" for status, count in found["without_verdict"].items())
    said = [f"samples without a verdict: {lost}, the first: {found['why']}"] if lost else []
    if found["ending"] == Ending.SPENT:
        said.append("more samples would narrow the interval")
    return "; ".join(said)


def add_uncertain(commands: Any) -> None:
    """Add the command to the parser's commands."""
    uncertain = commands.add_parser(
        "uncertain", help="how sure verdicts on labelled cases are: accuracy, probability, cost"
    )
    uncertain.add_argument(
        "--uncertain", metavar="WHAT", help="what deviates (default: com=5mm,position=3mm)"
    )
    uncertain.add_argument(
        "--method", "-m", action="append", metavar="SPEC",
        help="may be repeated (default: a rule, the equilibrium with time, a network, an engine)",
    )  # fmt: skip
    uncertain.add_argument(
        "--cases", type=at_least(1), metavar="N",
        help="a scenario, for methods without an engine (default: 100)",
    )  # fmt: skip
    uncertain.add_argument(
        "--engine-cases", type=at_least(1), metavar="N",
        help="a scenario, for methods with one (default: 20)",
    )  # fmt: skip
    uncertain.add_argument(
        "--checked", type=at_least(0), metavar="N",
        help="layouts that are held against many random samples (default: 50)",
    )  # fmt: skip
    uncertain.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/uncertain"),
        help="folder of what is sampled; an interrupted run goes on (default: runs/uncertain)",
    )  # fmt: skip
    uncertain.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    uncertain.add_argument("--workers", "-j", type=at_least(1), default=1, help="default: 1")
    uncertain.set_defaults(run=_uncertain)


def _uncertain(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.uncertain.page import uncertain_page
    from steadyload.studies.uncertain.study import Questions, run_uncertain
    from steadyload.studies.uncertain.summary import summarise

    made_with = provenance_lines()  # of the code that samples, not of what it has become meanwhile
    given = {
        "uncertainty": options.uncertain,
        "methods": options.method and tuple(dict.fromkeys(options.method)),
        "cases": options.cases,
        "engine_cases": options.engine_cases,
        "checked": options.checked,
    }
    asked = Questions(**{key: value for key, value in given.items() if value is not None})
    with resumable(options.work), progress_bar("sampling") as advance:
        sampled = run_uncertain(asked, options.work, workers=options.workers, progress=advance)
    page = uncertain_page(summarise(asked, sampled), made_with)
    print(write_page(page, options.output or options.work))
