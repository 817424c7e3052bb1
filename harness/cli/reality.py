"""``steadyload reality``: methods compared with what was measured of real loads."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.cli.reading import ReadingFlags
from steadyload.cli.terminal import kept_status, print_table, progress_bar, say
from steadyload.config import (
    REQUIRED,
    methods_option,
    number_from_zero,
    operand,
    option,
    positive_number,
)
from steadyload.escaping import printable

if TYPE_CHECKING:
    from steadyload.measured import Agreement, FieldTest, Prediction

DONE, NO_ANSWER = 0, 3
"""Exit statuses; 2 is bad input."""

_NAME = 24


@dataclass(frozen=True, kw_only=True)
class Field(ReadingFlags):
    """A table of field tests, the methods that are compared with it, and tolerances.

    Flags of reading are of the plans that the table names.
    """

    file: Path = operand(REQUIRED, "table of tests, CSV; see docs/field-test.md", metavar="FILE")
    methods: tuple[str, ...] = methods_option(
        "to compare, for example label@mujoco; may be repeated (default: "
        "equilibrium:sides=frictionless)"
    )
    deck_friction: float = option(
        0.5, "friction at the deck of the rule of thumb b/h, which comes after the methods "
        "(default: 0.5)", least=0, most=10,
    )  # fmt: skip
    tolerance_deg: float = option(
        2.0, "difference up to which a predicted angle agrees with the one that was seen "
        "(default: 2)", metavar="DEG", read=number_from_zero,
    )  # fmt: skip
    tolerance_g: float = option(
        0.05, "the same of accelerations (default: 0.05)", metavar="G", read=number_from_zero
    )
    timeout: float | None = option(
        None, "CPU seconds that the judgement of a loading may take", metavar="S",
        read=positive_number,
    )  # fmt: skip
    json: bool = option(False, "print one JSON array of records, units in the names")

    def run(self) -> int:
        """Compare, print one row for each test and method, and how often each method agrees."""
        from steadyload.measured import agreements, predictions, read_field_tests
        from steadyload.methods.registry import make_method
        from steadyload.transport.limits import EXACT

        methods = [make_method(spec) for spec in self.methods or (EXACT,)]
        table = read_field_tests(self.file, **self.reading())
        with progress_bar("predicting") as advance:
            found = predictions(
                table.tests, methods, deck_friction=self.deck_friction,
                tolerance_deg=self.tolerance_deg, tolerance_g=self.tolerance_g,
                timeout=self.timeout, progress=advance,
            )  # fmt: skip
        shares = agreements(found)
        with kept_status():
            if self.json:
                for comment in table.comments:
                    say(f"{self.file}: {comment}")
                print(json.dumps([one.to_dict() for one in found], indent=1))
            else:
                for comment in table.comments:
                    print(printable(comment))
                _print(found, shares)
        return NO_ANSWER if any(one.unanswered for one in shares) else DONE


def _print(found: Sequence[Prediction], shares: Sequence[Agreement]) -> None:
    from steadyload.measured.field_predictions import FEWEST

    rows = []
    for one in found:
        agrees = "-" if one.agrees is None else "yes" if one.agrees else "no"
        rows.append(
            (
                printable(one.test.name, _NAME), _done(one.test), _seen(one.test), one.method,
                _predicted(one), agrees,
            )
        )  # fmt: skip
    print_table(("test", "done", "seen", "method", "predicted", "agrees"), rows)
    print()
    for share in shares:
        print(_share(share, FEWEST))
    print("Complete loads: rigid boxes, without wrap, straps or anti-slip mats.")


def _done(test: FieldTest) -> str:
    if test.reached is None:
        return str(test.done)
    from steadyload.measured.field_tests import TOWARDS

    sides = {degrees: side for side, degrees in TOWARDS.items()}
    side = sides.get(test.towards_deg or 0.0, f"at {test.towards_deg:g} degrees")
    return f"{test.done} {side} to {_level(test, test.reached)}"


def _level(test: FieldTest, level: float) -> str:
    from steadyload.measured import Done

    return f"{level:.3g} degrees" if test.done is Done.TILTED else f"{level:.3g} g"


def _box(test: FieldTest, step: int | None) -> str:
    if step is None:
        return "a box"
    return printable(test.layout.items[step].name or f"step {step}", _NAME)


def _seen(test: FieldTest) -> str:
    if not test.moved:
        return "holds"
    if test.moved_at is not None:
        return f"{_box(test, test.moved_step)} at {_level(test, test.moved_at)}"
    return f"{_box(test, test.moved_step)} as {_box(test, test.moved_at_step)} is placed"


def _predicted(one: Prediction) -> str:
    test = one.test
    limit = one.limit_g if one.limit_deg is None else one.limit_deg
    if limit is not None:
        moved = "" if one.moved_item is None else f"{_box(test, one.moved_item)} {one.mode} at "
        return moved + _level(test, limit)
    if one.agrees is None:
        return printable(one.reason if one.applies else f"- ({one.reason})", 60)
    if one.failing_step is None:
        return "holds"
    moved = _box(test, one.moved_item)
    return f"{moved} as {_box(test, one.failing_step)} is placed"


def _share(one: Agreement, fewest: int) -> str:
    """How often a method agrees, in a sentence."""
    value = one.share
    if not value.n:
        told = "predicts none of these tests"
    else:
        told = f"agrees on {round(value.value * value.n)} of {value.n} tests"
        if value.n >= fewest:
            told += f" ({_percent(value.value)}, {_percent(value.low)} to {_percent(value.high)})"
        each = [f"{done} {hits} of {count}" for done, (hits, count) in one.counts.items()]
        told += f": {', '.join(each)}" if len(each) > 1 else ""
    lost = f"; no prediction for {one.unanswered}" if one.unanswered else ""
    return f"{one.method}: {told}{lost}"


def _percent(value: float) -> str:
    return f"{100.0 * value:.0f} %"
