"""``steadyload transport``: what a loaded pallet holds on the road."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from steadyload.cli.flags import UsageError
from steadyload.cli.reading import Files
from steadyload.cli.terminal import NAME, kept_status, print_table, progress_bar, say
from steadyload.config import option
from steadyload.escaping import printable

if TYPE_CHECKING:
    from steadyload.layouts.model.frame import Frame

HELD, NOT_HELD, BAD_INPUT, NO_ANSWER = 0, 1, 2, 3
"""Exit statuses; of several the worse one: bad input, then a load that does not hold."""


@dataclass(frozen=True, kw_only=True)
class Transport(Files):
    """Files, the method that answers, and what the loads are put through."""

    method: str = option(
        "equilibrium:sides=frictionless", "largest acceleration that contact forces balance, or a "
        "simulation such as label@mujoco (default: equilibrium:sides=frictionless)",
        names=("--method", "-m"), metavar="SPEC",
    )  # fmt: skip
    rule: str | None = option(
        None, "does every load hold this rule? en12195, eumos40509, tilt, or a TOML file "
        "(default: the largest acceleration that it holds)",
    )  # fmt: skip
    history: Path | None = option(
        None, "does every load hold this history? CSV of time_s, acceleration_g", metavar="FILE"
    )
    directions: int | None = option(
        None, "directions around the load (default: 8; a rule has its own)", least=1
    )
    limit: int | None = option(None, "only the first N layouts", least=1)
    json: bool = option(False, "print one JSON array of records, units in the names")

    def __post_init__(self) -> None:
        if self.rule and self.history:
            raise UsageError("--history: not allowed with --rule")
        if self.rule and self.directions:
            raise UsageError("--directions: not allowed with --rule, which has its own")

    def run(self) -> int:
        """Judge all loads and print a row a direction; the exit status tells the worst answer."""
        from steadyload.layouts.files.record import Refused
        from steadyload.layouts.model.frame import Frame
        from steadyload.runs.scoring import read_entries

        ask = self._asked()
        reading = self.reading()
        entries = read_entries(self.files, limit=self.limit, **reading)
        records: list[dict[str, Any]] = []
        status = HELD
        with progress_bar("judging") as advance:
            for done, (file, entry) in enumerate(entries, start=1):
                if isinstance(entry, Refused):
                    say(f"steadyload: {entry.error}")
                    status = BAD_INPUT
                else:
                    records += [_record(file, entry, asdict(one)) for one in ask(entry)]
                advance(done, len(entries))
        with kept_status():
            if self.json:
                print(json.dumps(records, indent=1))
            else:
                self._print(records, Frame.of(reading["dialect"]))
        return status or self._worst(records)

    def _asked(self) -> Callable[[Any], Sequence[Any]]:
        """A function of a layout that gives an answer a direction."""
        from steadyload.methods.registry import make_method
        from steadyload.transport.history import recorded
        from steadyload.transport.limits import DIRECTIONS, around, limits
        from steadyload.transport.rules import rule_named
        from steadyload.transport.trials import under_history, under_rule

        method = make_method(self.method)
        count = self.directions or DIRECTIONS
        if self.rule:
            rule = rule_named(self.rule)
            return lambda layout: under_rule(layout, rule, method)
        if self.history:
            history = recorded(self.history)
            return lambda layout: under_history(layout, history, around(count), method)
        return lambda layout: limits(layout, method, directions=count)

    @property
    def _answer(self) -> str:
        """The field of a record that has the answer."""
        return "held" if self.rule or self.history else "limit_g"

    def _print(self, records: Sequence[dict[str, Any]], frame: Frame) -> None:
        header = ("pallet", "direction", self._answer, "box", "mode", "moved")
        rows = []
        for one in records:
            moved = one["displacement_cm"]
            rows.append(
                (
                    printable(printable(one["layout"]), NAME),
                    f"{one['direction_deg']:g}",
                    _shown(one[self._answer]),
                    *_movement(one),
                    "-" if moved is None else frame.length(moved),
                )
            )
        print_table(header, rows, [one["file"] for one in records])
        print("Rigid boxes, without wrap, straps or anti-slip mats.")

    def _worst(self, records: Sequence[dict[str, Any]]) -> int:
        said = [one[self._answer] for one in records]
        if any(value is False for value in said):
            return NOT_HELD
        return NO_ANSWER if None in said else HELD


def _record(file: str, layout: Any, found: dict[str, Any]) -> dict[str, Any]:
    """An answer with the names of its layout and file, and the id of the box that moves."""
    from steadyload.layouts.model.naming import box_id

    box = box_id(layout.items, found["moved_item"])
    return {"layout": layout.name, "file": file, **found, "moved_box": box}


def _movement(record: dict[str, Any]) -> tuple[str, str]:
    """The box that moves, by its id or its number from 1, and how; or why there is no answer."""
    if record.get("held"):
        return "-", "-"
    item = record["moved_item"]
    box = "-" if item is None else printable(record["moved_box"] or str(item + 1))
    return box, printable(str(record["mode"] or record["reason"] or "-"))


def _shown(value: bool | float | None) -> str:
    if value is None:
        return "no answer"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3f}"
