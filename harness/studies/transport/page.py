"""The page of transport: what loads hold, by which method, and what the answer hangs on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.layouts.benchmark import REAL
from steadyload.layouts.benchmark.dataset import LISTS
from steadyload.reports.charts.scene import scene
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    counts,
    decimal,
    milliseconds,
    names,
    percent,
    words,
)
from steadyload.statistics.estimate import Estimate
from steadyload.studies.transport.figures import plot_differences, plot_limits
from steadyload.studies.transport.study import FRICTION, RUBBING, WHOLE
from steadyload.studies.transport.summary import (
    CLOSE,
    LEVELS,
    Distance,
    Drawn,
    TransportSummary,
)
from steadyload.transport.limits import DISPLACEMENT, EXACT, HELD, RESOLUTION, ROTATION

_SETS = {LISTS: "small", REAL: "real size"}


def _g(estimate: Estimate | None) -> str:
    return decimal(estimate, 3)


def transport_page(found: TransportSummary, made_with: Mapping[str, str]) -> Page:
    """Compose the page."""
    loads, planned, lists = found.counts[REAL]
    few, fewer, small_lists = found.counts[LISTS]
    least, most = found.boxes[REAL]
    return Page(
        "What loads hold on the road",
        f"{_answer(found)}\n\n{few} loads of at most {found.boxes[LISTS][1]} boxes "
        f"({small_lists} item lists) and {loads} of {least} to {most} boxes ({lists} item lists), "
        "all of which stand by their label, are pushed by a constant horizontal acceleration in "
        f"{found.directions} directions. Boxes are rigid, friction is {FRICTION:g} everywhere "
        "unless stated: **no wrap, no strap, no anti-slip mat.** What is held depends on the rule: "
        f"by simulation no box moves {DISPLACEMENT:g} cm or turns {ROTATION:g} degrees within "
        f"{HELD:g} s; by equilibrium forces inside Coulomb's cones balance every box where it was "
        "planned. "
        f"{fewer} of the {few} and {planned} of the {loads} loads balance as planned at all; the "
        "others stand because a box leans on its neighbour after it has moved a little, and hold "
        "nothing by equilibrium. Brackets hold 95 % intervals, of item lists drawn anew.",
        [
            _distances(found),
            _around(found.drawn),
            _holding(found),
            _rising(found),
            _real(found),
        ],
        dict(made_with),
    )  # fmt: skip


def _of(found: Sequence[Distance], spec: str) -> Distance | None:
    return next((one for one in found if one.method.spec == spec), None)


def _answer(found: TransportSummary) -> str:
    engines = [one for one in found.small if one.method.engine]
    exact, whole = _of(found.small, EXACT), _of(found.small, WHOLE)
    if exact is None or whole is None or not engines:
        return "No load balances as planned, so that nothing can be compared."
    best = min(engines, key=lambda one: one.apart.value)
    weakest = next(h for h in found.holding if h.of == REAL and h.method.spec == EXACT)
    return (
        f"Loads of real size that balance as planned hold {_g(weakest.weakest)} g in their weakest "
        f"direction in the mean, {percent(weakest.share[0.3])} % of them 0.3 g in every direction. "
        f"On small loads {_beside(exact, whole)}; the engine nearest to the reference is "
        f"{best.method.title} ({_g(best.apart)} g apart).{_beside_of_real(found.real)}"
    )


def _beside(exact: Distance, whole: Distance) -> str:
    return (
        f"the limit by equilibrium less the reference's is {_g(exact.difference)} g in the mean "
        f"({exact.difference.n} limits); more than {CLOSE:g} g too much is promised by "
        f"{percent(exact.above)} % of its limits, and by {percent(whole.above)} % of those of the "
        "rule of thumb, b / h of the whole load"
    )


def _beside_of_real(real: Sequence[Distance]) -> str:
    exact, whole = _of(real, EXACT), _of(real, WHOLE)
    if exact is None or whole is None:
        return ""
    return f" On {exact.loads} loads of real size with few boxes {_beside(exact, whole)}."


_DISTANCE = (
    words("method", "method.title"),
    Column("n", "difference.n"),
    Column("less the other, g", "difference", _g),
    Column(f"> {CLOSE:g} g above %", "above", percent),
    Column(f"> {CLOSE:g} g below %", "below", percent),
    Column("CPU ms a direction", "cpu", milliseconds),
)


def _distances(found: TransportSummary) -> Section:
    fewest = "Loads of real size, of those with the fewest boxes,"
    beside = (
        ("Small loads that balance as planned", found.small),
        ("Small loads that lean on a neighbour", found.leaning),
        (f"{fewest} that balance as planned", found.real),
        (f"{fewest} that lean on a neighbour", found.real_leaning),
    )
    tables = [
        Table(own, _DISTANCE, f"**{about}** ({max(one.loads for one in own)} loads)")
        for about, own in beside
        if own
    ]
    lost = counts({_named(m): n for m, n in found.without.items()}) if found.without else "none"
    return Section(
        "How far limits are from the reference's",
        "A limit is told by method and direction. *n*: limits that both have. *Above*: it promises "
        "more than the reference holds, which is the dangerous side. The limit by equilibrium is "
        "an upper bound of what is held without any motion, since Coulomb friction is not "
        "associated; a simulation allows some motion, and may hold more. *Side faces rub*: "
        "friction at the faces of neighbours counts as well, which admits jammed states. A limit "
        f"of a simulation is known to {RESOLUTION:g} g. Limits without an answer, by method: "
        f"{lost}.",
        tables,
        [
            Picture(
                "differences",
                plot_differences(found.small),
                "Share of limits that differ from the reference's by at most so much, on small "
                "loads that balance as planned.",
            )
        ],
    )


def _named(spec: str) -> str:
    return {RUBBING: "equilibrium, side faces rub", EXACT: "equilibrium"}.get(spec, spec)


def _around(drawn: Sequence[Drawn]) -> Section:
    if not drawn:
        return Section("Limits around loads", "No load of real size balances as planned.")
    weakest = drawn[0]
    return Section(
        "Limits around loads",
        "Three loads of real size: of all that balance as planned, those at a tenth, at the middle "
        "and at nine tenths of their weakest limits.",
        pictures=[
            Picture(
                "around",
                plot_limits(drawn),
                "Largest acceleration that is held (g), by direction of the force on the boxes, "
                "seen from above: 0 degrees along the load's width.",
            ),
            Picture(
                "weakest",
                scene(weakest.load.layout, title="", marked=[weakest.moved_item]).figure,
                f"Load {weakest.load.name}: box {weakest.moved_item} {weakest.mode} at "
                f"{weakest.weakest:.3f} g.",
            ),
        ],
    )


def _holding(found: TransportSummary) -> Section:
    held = columns_for(LEVELS, "{:g} g held %", lambda row, level: row.share[level], percent)
    columns = [
        words("loads", lambda row: _SETS[row.of]),
        words("method", "method.title"),
        Column("weakest, g", "weakest", _g),
        *held,
        Column("tips %", "tips", percent),
    ]
    of_friction = [
        Column("friction", 0, "{:g}".format),
        words("loads", lambda row: _SETS[row[1].of]),
        Column("weakest, g", lambda row: row[1].weakest, _g),
        *columns_for(LEVELS, "{:g} g held %", lambda row, level: row[1].share[level], percent),
    ]
    return Section(
        "What loads hold in their weakest direction",
        "Of loads that balance as planned. *Held*: in every direction. *Tips*: share of limits "
        "beyond which a box tips, by equilibrium; else one slides. No load holds more than its "
        "friction, so that 0.8 g, which EN 12195-1 asks forwards, is beyond all of them.",
        [
            Table(found.holding, columns),
            Table(found.frictions, of_friction, "**By friction, by equilibrium**"),
        ],
    )


def _rising(found: TransportSummary) -> Section:
    rises = names(f"{one.rise:g} s {_g(one.more)} g" for one in found.rises)
    return Section(
        "What the rise time changes",
        "Where an acceleration does not act at once but rises, small loads hold more or less than "
        f"at once by, in the mean ({names({one.method.title for one in found.rises})}): {rises}. "
        f"It is held for {HELD:g} s in each case.",
    )


def _real(found: TransportSummary) -> Section:
    return Section(
        f"Loads of real size, beside {found.against}",
        "On all loads of real size, of which the reference was asked of some alone; the first "
        "engine stands in its place. Unless others were named, these are the engines whose tuned "
        "simulation no cheaper one beats on the largest loads that `steadyload recommend` knows, "
        "where these have to stand.",
        [Table(found.engines, _DISTANCE)],
    )
