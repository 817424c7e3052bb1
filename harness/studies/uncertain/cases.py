"""Sampling of one labelled case: a row for the page of uncertain verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method, judge
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import dimensions, judge_deviated, parse_uncertainty
from steadyload.runs.asked import AskedCases, asked
from steadyload.runs.verdict_reliability import (
    Sampling,
    variance_by_scramblings,
    verdict_reliability,
)

VERSION = 1
"""Version of the samples of a case: raised when rows change."""

Row = dict[str, Any]
"""``layout, scenario, item_count``; ``nominal``, items placed safely by the plan (all: it stands),
None without a verdict; ``safe``, the same of samples, with how many; ``samples, lost``; ``low,
high, ending``; ``variance`` of the share that stands; ``cpu, nominal_cpu`` [s]; ``random``, the
share of random samples that stand, None where there were none."""


@dataclass(frozen=True, slots=True)
class SampledMethod:
    """How verdicts of a method are sampled.

    Attributes:
        method: its spec.
        uncertainty: the deviating quantities, as :func:`parse_uncertainty` reads them.
        sampling: the rule by which sampling ends.
        random: number of random samples besides.
    """

    method: str
    uncertainty: str
    sampling: Sampling
    random: int = 0


def _said(sampled: SampledMethod) -> list[Any]:
    uncertainty = str(parse_uncertainty(sampled.uncertainty))
    return [sampled.method, uncertainty, repr(sampled.sampling), int(sampled.random)]


class Unit(AskedCases, what="certainty"):
    """One method and uncertainty on some cases."""

    sampled: SampledMethod = asked("asked", said=_said)
    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of a case for messages."""
        asked = self.sampled
        return f"{asked.method} on {super().describe(part)}, {asked.uncertainty}"


def sample_unit(unit: Unit) -> Iterator[Row]:
    """Prepare a unit's method, then sample: a row a case."""
    method = make_method(unit.sampled.method)
    method.prepare(max(len(layout) for _, layout in unit.cases))
    return _rows(method, unit)


def _rows(method: Method, unit: Unit) -> Iterator[Row]:
    # One by one and in a batch, so that no time holds imports or compilation.
    first, sampled = unit.cases[0][1], unit.sampled
    judge(method, first)
    numbers = np.full((2, dimensions(len(first))), 0.5)
    judge_deviated(method, first, parse_uncertainty(sampled.uncertainty), numbers)
    for scenario, layout in unit.cases:
        yield _row(method, sampled, scenario, layout)


def _row(method: Method, sampled: SampledMethod, scenario: str, layout: Layout) -> Row:
    uncertainty = parse_uncertainty(sampled.uncertainty)
    found = verdict_reliability(method, layout, uncertainty, sampled.sampling)
    stands = [safe == len(layout) for safe in found.said]
    return {
        "layout": layout.name,
        "scenario": scenario,
        "item_count": len(layout),
        "nominal": found.nominal.items_placed,
        "safe": sorted(Counter(s for s in found.said if s is not None).items()),
        "samples": found.samples,
        "lost": sum(found.without_verdict.values()),
        "low": found.low,
        "high": found.high,
        "ending": str(found.ending),
        "variance": variance_by_scramblings(stands) if stands else None,
        "cpu": found.cpu,
        "nominal_cpu": found.nominal.cpu.total,
        "random": _random_share(method, sampled, layout) if sampled.random else None,
    }


def _random_share(method: Method, sampled: SampledMethod, layout: Layout) -> float:
    """Share of random samples that stand, drawn independently of the quasi-random ones."""
    digest = int(layout.content_hash()[:8], 16)
    random = np.random.default_rng([sampled.sampling.seed, digest])
    uniforms = random.random((sampled.random, dimensions(len(layout))))
    verdicts = judge_deviated(method, layout, parse_uncertainty(sampled.uncertainty), uniforms)
    return float(np.mean([verdict.stable for verdict in verdicts]))


def crashed_row(unit: Unit, part: int, reason: str) -> Row:
    """The row of a case that ends the process it is judged in."""
    scenario, layout = unit.cases[part]
    return {
        "layout": layout.name, "scenario": scenario, "item_count": len(layout), "nominal": None,
        "safe": [], "samples": 0, "lost": 0, "low": 0.0, "high": 1.0, "variance": None,
        "ending": f"crashed: {reason}", "cpu": 0.0, "nominal_cpu": 0.0, "random": None,
    }  # fmt: skip
