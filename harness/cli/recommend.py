"""``steadyload recommend``: which method to use, by what was measured."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.readers import milliseconds, share
from steadyload.cli.terminal import print_table, say
from steadyload.studies.options import option


@dataclass(frozen=True)
class Recommend:
    """A time, or an accuracy."""

    budget: float | None = option(
        None, "CPU time a layout, such as 5ms: the most accurate method within it",
        metavar="TIME", read=milliseconds,
    )  # fmt: skip
    accuracy: float | None = option(
        None, "such as 0.95 or 95%: the cheapest method that is right as often",
        metavar="SHARE", read=share,
    )  # fmt: skip
    engine: str | None = option(None, "only methods on this engine, and those that need none")
    run_folder: Path | None = option(
        None, "run folder of a study on a labelled set (default: what comes with the package)",
        names=("--from",), metavar="RUN",
    )  # fmt: skip
    write: bool = option(False, "make the run what comes with the package")

    def run(self) -> None:
        """Name the method, and print those it was chosen from."""
        from steadyload.studies.table5.front import (
            FrontError,
            best,
            load_front,
            measured_in,
            recommend,
            told,
            write_front,
        )

        if self.write and self.run_folder is None:
            raise FrontError("--write needs --from RUN: the run to be kept")
        front = measured_in(self.run_folder) if self.run_folder else load_front()
        if self.write:
            print(write_front(front))
            return
        chosen = recommend(front, budget=self.budget, accuracy=self.accuracy, engine=self.engine)
        print(told(chosen) + "\n")
        print_table(
            ("", "method", "accuracy %", "95 % interval", "CPU ms"),
            [
                (
                    "->" if entry == chosen else "",
                    entry.method,
                    f"{100 * entry.accuracy.value:.1f}",
                    f"{100 * entry.accuracy.low:.1f} to {100 * entry.accuracy.high:.1f}",
                    f"{entry.cpu.value:.3g}",
                )
                for entry in best(front, self.engine)
            ],
        )
        if self.accuracy is not None and chosen.accuracy.low < self.accuracy:
            say(f"The interval of {chosen.method} reaches below {100 * self.accuracy:g} %.")
        about = [front.about["measured on"]]
        if "timed on" in front.about:
            about.append(f"timed on {front.about['timed on']}")
        print("\n" + "; ".join([*about, front.about["machine"]]))
