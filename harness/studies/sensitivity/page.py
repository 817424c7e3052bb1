"""The page of rules: which conclusions survive, ranks, and accuracy under every rule."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import attrgetter

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    names,
    percent,
    plain_percent,
    words,
)
from steadyload.studies.sensitivity.figures import plot_ranks
from steadyload.studies.sensitivity.rules import LIMITS, RULES, TIMES, Rule
from steadyload.studies.sensitivity.summary import (
    Claim,
    Fate,
    Knowledge,
    Place,
    Ranking,
    Sensitivity,
)

_BY_VALUE = attrgetter("value")
_SHORT = {rule.name: rule.short for rule in RULES}


def sensitivity_page(found: Sensitivity) -> Page:
    """Compose the page."""
    sections = [
        ranks_section(found),
        _claims(found),
        _labels(found),
        *(_accuracies(found, knowledge) for knowledge in Knowledge),
    ]
    return Page(
        "Conclusions under other rules", f"{what_survives(found)} {_about(found)}", sections,
        found.manifest,
    )  # fmt: skip


def what_survives(found: Sensitivity) -> str:
    """The sentences on conclusions that survive every rule, are turned round, or stay open."""
    told = [claim for claim in found.claims if claim.knowledge is Knowledge.TOLD]
    standing = [claim for claim in found.claims if claim.knowledge is Knowledge.NONE]
    if not told:
        return "No conclusion is compared: the methods that take part are in none."
    rules = len(found.by(Knowledge.TOLD))
    both = [c for c in told if c.fate is Fate.SURVIVES and _twin(c, standing).fate is c.fate]
    parts = [
        f"Of {len(told)} conclusions that Table 5 invites, {_hold(len(both))} under all {rules} "
        f"rules, whether methods are told the rule or not{_listed(both)}."
    ]
    more = [c for c in told if c.fate is Fate.SURVIVES and c not in both]
    if more:
        parts.append(
            f"Where methods are told the rule, {len(more)} more {_verb(len(more))}{_listed(more)}."
        )
    for claims, where in (
        (standing, "by some rule where methods are not told it"),
        (told, "even where they are told"),
    ):
        turned = [
            f"{_plain(c)} ({names(map(_short, c.turned))})" for c in claims if c.fate is Fate.TURNS
        ]
        if turned:
            parts.append(f"Turned round {where}: {'; '.join(turned)}.")
    unsure, sure = (sum(c.fate is Fate.OPEN for c in claims) for claims in (standing, told))
    if unsure or sure:
        parts.append(
            f"Open are {unsure} where methods are not told the rule, and {sure} where they are: "
            "under some rule the interval of the difference includes 0, which speaks neither for "
            "nor against the conclusion."
        )
    return " ".join(parts)


def _hold(count: int) -> str:
    return f"{count} {_verb(count)}"


def _verb(count: int) -> str:
    return "holds" if count == 1 else "hold"


def _twin(claim: Claim, among: Sequence[Claim]) -> Claim:
    return next(other for other in among if other.text == claim.text)


def _listed(claims: Sequence[Claim]) -> str:
    return f": {'; '.join(map(_plain, claims))}" if claims else ""


def _plain(claim: Claim) -> str:
    """A conclusion within a sentence."""
    return claim.text.removesuffix(".")


def _about(found: Sensitivity) -> str:
    lost = "".join(
        f" Under *{_short(name)}* the reference has no verdict on {n} cases, which are left out."
        for name, n in found.lost.items()
    )
    return (
        f"All on {found.cases} cases of {found.item_lists} item lists of the test part, half of "
        "them stable by the usual rule, labelled by the reference under every rule. A difference "
        "counts where its 95 % interval, clustered by item list, leaves out 0; no correction is "
        f"made for the number of comparisons.{lost}"
    )


def ranks_section(found: Sensitivity) -> Section:
    """The chart of ranks over rules."""
    return Section(
        "Rank of every method over the rule",
        "*Told the rule*: a simulation or an equilibrium has the time, the thresholds and the "
        "criterion of the rule, a learner or a cascade that of the question `stands`; static rules "
        "have nothing to be told. *As it stands*: every method keeps its own.",
        [],
        [
            Picture(
                "ranks",
                plot_ranks(found),
                "Rank by accuracy under every rule: on the left the time that a placement is "
                "watched, on the right thresholds and what is measured; above methods as they "
                "stand, below told the rule.",
            )
        ],
    )


def _claims(found: Sensitivity) -> Section:
    columns = (
        words("conclusion", "text"),
        words("methods", lambda claim: str(claim.knowledge)),
        words("fate", lambda claim: str(claim.fate)),
        Column("holds under", lambda c: f"{len(c.holds)} of {len(c.differences)}"),
        words("turned under", lambda claim: names(map(_short, claim.turned))),
        Column("least difference", lambda c: percent(min(c.differences.values(), key=_BY_VALUE))),
        Column("greatest", lambda c: percent(max(c.differences.values(), key=_BY_VALUE))),
    )
    rows = sorted(found.claims, key=lambda claim: list(Fate).index(claim.fate))
    return Section(
        "Conclusions",
        "*Holds*: the interval of the difference in accuracy lies above 0; *turned*: below it. "
        f"Differences in percentage points, n = {found.cases} under each rule.",
        [Table(rows, columns)],
    )


def _labels(found: Sensitivity) -> Section:
    rows = found.by(Knowledge.NONE)
    columns = (
        words("rule", lambda r: r.rule.name),
        Column("n", lambda r: r.places[0].accuracy.n),
        Column("stable %", lambda r: plain_percent(r.stable)),
        Column("label changed %", lambda r: plain_percent(r.changed)),
        words("most accurate as it stands", lambda r: _first(r)),
        words("told the rule", lambda r: _first(_informed(found, r.rule))),
    )
    return Section(
        "Labels under every rule",
        "*Label changed*: cases whose failing step is not that of the usual rule.",
        [Table(rows, columns)],
    )


def _informed(found: Sensitivity, rule: Rule) -> Ranking:
    return next(r for r in found.by(Knowledge.TOLD) if r.rule is rule)


def _first(ranking: Ranking) -> str:
    best = [place for place in ranking.places if place.rank == 1]
    return f"{names(p.method.title for p in best)}, {percent(best[0].accuracy)}"


def _accuracies(found: Sensitivity, knowledge: Knowledge) -> Section:
    rankings = {ranking.rule.name: ranking for ranking in found.by(knowledge)}
    tables = [
        _table(found, rankings, rules, caption)
        for rules, caption in (
            (TIMES, "By time:"),
            (LIMITS, "By threshold, and by what is measured:"),
        )
    ]
    return Section(f"Accuracy, methods {knowledge}", "In %.", tables)


def _table(
    found: Sensitivity, rankings: dict[str, Ranking], rules: Iterable[Rule], caption: str
) -> Table:
    rows = [
        (method.title, {name: r.of(method.spec) for name, r in rankings.items()})
        for method in found.methods
    ]

    def accuracy(row: tuple[str, dict[str, Place]], name: str) -> str:
        return percent(row[1][name].accuracy)

    columns = [
        words("method", 0),
        *columns_for([rule.name for rule in rules], _short, accuracy),
    ]
    return Table(rows, columns, caption)


def _short(name: str) -> str:
    return _SHORT[name]
