"""``steadyload score``: judge layout files."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TextIO

from steadyload.app.check_defaults import default_help, default_method, default_methods
from steadyload.cli.flags import UsageError
from steadyload.cli.reading import SOME_REFUSED, Files, Strict, say_refused
from steadyload.cli.terminal import print_table, progress_bar, say
from steadyload.config import methods_option, option, positive_number, stated


@dataclass(frozen=True, kw_only=True)
class Score(Strict, Files):
    """Files, methods, and the required reliability of a verdict."""

    methods: tuple[str, ...] = methods_option(
        "for example sme, pbs:alpha=0.7, ps3@mujoco; may be repeated "
        f"({default_help()}, by the largest layout)"
    )
    scenario: str | None = option(
        None, "draw centres of mass (default: as in the file)",
        choices="steadyload.layouts.model.scenarios:Scenario",
    )  # fmt: skip
    seed: int = option(0, "of scenario and deviations (default: 0)", least=0)
    uncertain: str | None = option(
        None, "how probable it is that the load stands when it deviates from its plan by, for "
        "example, com=5mm,position=3mm,weight=5%,friction=0.1 (standard deviations)",
        metavar="WHAT",
    )  # fmt: skip
    half_width: str | None = option(
        None, "with --uncertain: sample until the probability is known to W (default: 0.05)",
        metavar="W",
    )  # fmt: skip
    decide: str | None = option(
        None, "with --uncertain: or until it is known to lie above or below P", metavar="P"
    )
    samples: int | None = option(
        None, "with --uncertain: at most so many, 64 times a power of two (default: 1024)", least=1
    )
    max_items: int | None = option(None, "only the first J items", metavar="J", least=1)
    limit: int | None = option(None, "only the first N layouts", least=1)
    skip_invalid: bool = option(
        False, "end with status 0 although layouts were refused, and name them in the table only"
    )
    timeout: float | None = option(
        None, "CPU seconds a judgement may take", metavar="S", read=positive_number
    )
    json: bool = option(False, "print one JSON array of records")

    def __post_init__(self) -> None:
        if self.skip_invalid and self.strict:
            raise UsageError("--skip-invalid: not allowed with --strict")

    def run(self) -> int:
        """Judge, warn, print."""
        from steadyload.cli.score_tables import uncertain_table, verdict_table, without_effect
        from steadyload.layouts.model.scenarios import Scenario
        from steadyload.methods.registry import make_method
        from steadyload.runs.able import asked_to_stand
        from steadyload.runs.entries import Entries, scan_entries
        from steadyload.runs.envelope_use import ScoreWarnings
        from steadyload.runs.scoring import Record, score_entries

        warnings, sampled, files = ScoreWarnings(), dict[str, Record](), list[str]()

        def counted(records: Iterable[Record]) -> Iterator[Record]:
            for record in records:
                warnings.add(record)
                files.append(record["file"])
                if record.get("uncertain"):
                    sampled[record["method"]] = record
                yield record

        out = sys.stdout  # a bar puts another in its place
        with progress_bar("judging", shown=not (self.json and out.isatty())) as advance:
            scenario = Scenario(self.scenario) if self.scenario else None
            reading, deviations = self.reading(), self._deviations()
            judges = [asked_to_stand(spec) for spec in self.methods]
            scanned = scan_entries(self.files, limit=self.limit, strict=self.strict, **reading)
            with Entries(scanned) as entries:
                some_refused = bool(entries.refused.count) and not self.skip_invalid
                if some_refused:
                    say_refused(entries.refused, entries.valid)
                    if not entries.valid:
                        return 2
                judges = judges or [make_method(self._default(entries.sizes))]
                records = score_entries(
                    entries, judges, scenario=scenario, seed=self.seed, max_items=self.max_items,
                    timeout=self.timeout, **deviations, progress=advance,
                )  # fmt: skip
                table = None
                if self.json:
                    _write_json(counted(records), out)
                else:
                    tabled = verdict_table if self.uncertain is None else uncertain_table
                    table = tabled(counted(records))
        for warning in [*warnings.sentences, *without_effect(sampled.values())]:
            say(warning)
        if table is not None:
            print_table(*table, files)
        return SOME_REFUSED if some_refused else 0

    def _default(self, sizes: Iterable[int]) -> str:
        """Spec of the one method that judges all layouts: that for the largest."""
        cut = [min(size, self.max_items or size) for size in sizes] or [1]
        chosen = default_method(max(cut))
        if len(default_methods(cut)) > 1:
            say(f"all layouts are judged by {chosen}, the default for {max(cut)} boxes")
        return chosen

    def _deviations(self) -> dict[str, Any]:
        """Arguments on deviations and their sampling; empty without ``--uncertain``.

        Raises:
            SpecError: not of the form, out of range, or an option that needs ``--uncertain``.
        """
        from steadyload.methods.contract.spec import SpecError, bind
        from steadyload.methods.uncertainty import parse_uncertainty
        from steadyload.runs.verdict_reliability import Sampling

        values = stated(half_width=self.half_width, decide=self.decide, most=self.samples)
        if self.uncertain is None:
            if values:
                raise SpecError("--half-width, --decide and --samples need --uncertain")
            return {}
        sampling = bind(Sampling, {**values, "seed": self.seed}, where="sampling")
        return {"uncertainty": parse_uncertainty(self.uncertain), "sampling": sampling}


def _write_json(records: Iterable[Mapping[str, Any]], out: TextIO) -> None:
    """Write a JSON array, each record as it comes; without its end where one does not come."""
    encoder, before = json.JSONEncoder(indent=1), "["
    for record in records:
        out.write(before + encoder.encode([record]).removeprefix("[").removesuffix("\n]"))
        before = ","
    out.write("\n]\n")
