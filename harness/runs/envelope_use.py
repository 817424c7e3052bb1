"""Cases of a study or a score that lie beyond the envelope of an engine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from steadyload.layouts.model import Layout
from steadyload.methods.envelope import Limit, beyond, envelope_of, extent
from steadyload.methods.registry import make_method

EnvelopeUse = dict[str, dict[str, Any]]
"""By method: ``measured``; where that is true also ``cases`` beyond the envelope, ``of`` how many,
and ``reasons``, the most frequent first: ``limit``, ``cases``, the first one as ``example``, and
the ``sentence`` that says how far it goes."""


class EnvelopeCount:
    """Counts cases beyond envelopes, one after the other.

    Args:
        methods: spec strings; those without an engine are left out.
    """

    def __init__(self, methods: Iterable[str]) -> None:
        judges = {spec: make_method(spec) for spec in methods}
        self._held = {
            spec: envelope_of(method) for spec, method in judges.items() if method.spec.engine
        }
        self._of = 0
        self._beyond = dict.fromkeys(self._held, 0)
        self._reasons: dict[str, dict[Limit, dict[str, Any]]] = {spec: {} for spec in self._held}

    def add(self, layout: Layout) -> None:
        """Count a case."""
        self._of += 1
        known = {spec: held for spec, held in self._held.items() if held is not None}
        reach = extent(layout) if known else None
        for spec, held in known.items():
            assert reach is not None
            said = beyond(reach, held)
            self._beyond[spec] += bool(said)
            for limit, sentence in said.items():
                first = {
                    "limit": str(limit), "cases": 0, "example": layout.name, "sentence": sentence
                }  # fmt: skip
                self._reasons[spec].setdefault(limit, first)["cases"] += 1

    @property
    def use(self) -> EnvelopeUse:
        """The entry of a manifest on envelopes."""
        return {
            spec: {"measured": False} if held is None else self._use(spec)
            for spec, held in self._held.items()
        }

    def _use(self, spec: str) -> dict[str, Any]:
        reasons = [self._reasons[spec][limit] for limit in Limit if limit in self._reasons[spec]]
        return {
            "measured": True,
            "cases": self._beyond[spec],
            "of": self._of,
            "reasons": sorted(reasons, key=lambda r: -r["cases"]),
        }


def study_warnings(use: EnvelopeUse) -> list[str]:
    """A warning for each method that judges cases beyond the envelope of its engine."""
    return [
        _warning(spec, entry["cases"], entry["of"], first["example"], first["sentence"])
        for spec, entry in use.items()
        for first in entry.get("reasons", [])[:1]
    ]


def score_warnings(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """The same warnings for records with ``method``, ``layout``, ``outside`` and ``doubt``.

    There is one more for each method that sees loads inside the envelope fall although they are in
    balance.

    As :func:`steadyload.runs.scoring.score_layouts` and :func:`steadyload.studies.checking.check`
    give them.
    """
    by_method: dict[str, list[Mapping[str, Any]]] = {}
    for record in records:
        by_method.setdefault(record["method"], []).append(record)
    warnings = []
    for spec, mine in by_method.items():
        outside = [record for record in mine if record["outside"]]
        if outside:
            first = outside[0]
            sentence = first["outside"][0]
            warnings.append(_warning(spec, len(outside), len(mine), first["layout"], sentence))
        doubtful = [record for record in mine if record["doubt"] and not record["outside"]]
        if doubtful:
            first = doubtful[0]
            warnings.append(
                f"warning: {spec}: {len(doubtful)} of {len(mine)} cases fail although the load is "
                f'in balance; for example layout "{first["layout"]}": {first["doubt"]}'
            )
    return warnings


def _warning(spec: str, cases: int, of: int, example: str, sentence: str) -> str:
    return (
        f"warning: {spec}: {cases} of {of} cases lie beyond what its engine was measured to hold; "
        f'for example layout "{example}": {sentence}'
    )
