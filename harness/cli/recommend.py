"""``steadyload recommend``: the choice of a method, by measurements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.cli.readers import milliseconds, positive, share
from steadyload.cli.terminal import print_table, say
from steadyload.config import option

if TYPE_CHECKING:
    from steadyload.app.recommend.front import Front, Measured
    from steadyload.layouts.model.question import Question


@dataclass(frozen=True)
class Recommend:
    """A time, or an accuracy; the layouts, and what is asked of them."""

    budget: float | None = option(
        None, "CPU time a layout, such as 5ms: the most accurate method within it",
        metavar="TIME", read=milliseconds,
    )  # fmt: skip
    accuracy: float | None = option(
        None, "such as 0.95 or 95%: the cheapest method that is right as often",
        metavar="SHARE", read=share,
    )  # fmt: skip
    overestimation_costs: float | None = option(
        None, "cost of an overestimation, where an underestimation costs 1: the method whose "
        "errors cost least, instead of the most accurate one",
        metavar="RATIO", read=positive,
    )  # fmt: skip
    boxes: int | None = option(
        None, "number of boxes of a layout (default: the smallest layouts that were measured)",
        least=1,
    )  # fmt: skip
    question: str | None = option(
        None, "stands: does anything move too far until all rests; within: has anything within "
        "0.3 s (default: stands, as of steadyload check, where it was measured)",
        choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    engine: str | None = option(None, "only methods on this engine, and those that need none")
    run_folder: Path | None = option(
        None, "work folder of steadyload study evaluation, or run folder of a study on a labelled "
        "set (default: what comes with the package)",
        names=("--from",), metavar="RUN",
    )  # fmt: skip
    write: bool = option(
        False, "keep the run with the package, in the place of earlier measurements of its cases"
    )

    def run(self) -> None:
        """Print the method, and those from which it was chosen."""
        from steadyload.app.recommend.front import FrontError, described, front_for, recommend
        from steadyload.app.recommend.kept import load_fronts

        if self.run_folder is not None:
            from steadyload.app.recommend.folder import measured_in

            fronts = measured_in(self.run_folder)
        elif self.write:
            raise FrontError("--write needs --from RUN: the run to be kept")
        else:
            fronts = load_fronts()
        if self.write:
            self._keep(fronts)
            return
        front = front_for(fronts, self._question(fronts), self.boxes)
        if self.engine is None:
            front = front.here()
        chosen = recommend(
            front, budget=self.budget, accuracy=self.accuracy, engine=self.engine,
            overestimation_costs=self.overestimation_costs,
        )  # fmt: skip
        print(described(chosen, self.overestimation_costs) + "\n")
        self._table(front, chosen)
        print("\n" + front.measured_on())
        self._remarks(front, chosen, fronts)

    def _question(self, fronts: tuple[Front, ...]) -> Question:
        """The question that is asked for, or else the default one, or the only one measured."""
        from steadyload.layouts.model.question import Question

        measured = {front.question for front in fronts}
        if self.question is None and len(measured) == 1:
            return measured.pop()
        return Question(self.question or Question.STANDS)

    def _keep(self, fronts: tuple[Front, ...]) -> None:
        from steadyload.app.recommend.kept import FILE, load_fronts, merged, write_fronts

        kept = merged(load_fronts(FILE) if FILE.exists() else (), fronts)
        print(write_fronts(kept, FILE))
        for front in fronts:
            if front not in kept:
                say(f"Not kept, since another study has more cases: {front.measured_on()}")

    def _table(self, front: Front, chosen: Measured) -> None:
        from steadyload.app.recommend.front import best

        ratio = self.overestimation_costs
        shown = best(front.measured, self.engine, ratio)
        if ratio is not None and chosen not in shown:  # another one was not accurate enough
            shown = sorted([*shown, chosen], key=lambda entry: entry.cpu.value)
        own = _ACCURACY if ratio is None else _ERRORS
        rows = [("->" if e == chosen else "", e.method, *_cells(e, ratio)) for e in shown]
        print_table(("", "method", *own), rows)

    def _remarks(self, front: Front, chosen: Measured, fronts: tuple[Front, ...]) -> None:
        from steadyload.app.recommend.front import sizes_of

        others = [f for f in fronts if f.question == front.question and f.sizes != front.sizes]
        if self.boxes is None and others:
            say(f"Other sizes (--boxes) that were measured: {sizes_of(others)} boxes.")
        if self.boxes is not None and front.beyond(self.boxes):
            say(
                f"No layout of {self.boxes} boxes was measured: those of {front.sizes} are nearest."
            )
        if self.accuracy is not None and chosen.accuracy.low < self.accuracy:
            say(f"The interval of {chosen.method} reaches below {100 * self.accuracy:g} %.")
        for spec, why in front.left_out.items():
            say(f"{spec} is left out: {why}.")


_ACCURACY = ("accuracy %", "95 % interval", "CPU ms", "no verdict")
_ERRORS = ("cost of errors", "95 % interval", "over %", "under %", "CPU ms")


def _cells(entry: Measured, ratio: float | None) -> tuple[str, ...]:
    """Cells of a method: its accuracy, or the cost of its errors where a ratio is given."""
    right, cpu = entry.accuracy, f"{entry.cpu.value:.3g}"
    if ratio is None:
        interval = f"{100 * right.low:.1f} to {100 * right.high:.1f}"
        return f"{100 * right.value:.1f}", interval, cpu, str(entry.without_verdict or "-")
    from steadyload.app.recommend.front import error_cost

    cost, errors = error_cost(entry, ratio), entry.errors
    assert errors is not None, "the cost of its errors was computed"
    shares = (f"{100 * share.value:.1f}" for share in (errors.over, errors.under))
    return f"{cost.value:.3g}", f"{cost.low:.3g} to {cost.high:.3g}", *shares, cpu
