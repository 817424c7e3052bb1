"""Cases of a study or a score that lie beyond the envelope of an engine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method
from steadyload.methods.envelope import Limit, beyond, envelope_of, extent, farthest

EnvelopeUse = dict[str, dict[str, Any]]
"""By method: ``measured``; where that is true also ``cases`` beyond the envelope, ``of`` how many,
and ``reasons``, the most frequent first: ``limit``, ``cases``, the first one as ``example``, and
the ``sentence`` that says how far it goes."""


class EnvelopeCount:
    """Counts cases beyond envelopes, one after the other.

    Args:
        methods: those without an engine are left out.
    """

    def __init__(self, methods: Iterable[Method]) -> None:
        self._held = {str(one.spec): envelope_of(one) for one in methods if one.spec.engine}
        self._known = {spec: held for spec, held in self._held.items() if held is not None}
        self._of = 0
        self._beyond = dict.fromkeys(self._held, 0)
        self._reasons: dict[str, dict[Limit, dict[str, Any]]] = {spec: {} for spec in self._held}

    def add(self, layout: Layout) -> None:
        """Count a case."""
        self._of += 1
        if not self._known:
            return
        most = farthest(layout)
        suspects = {spec: held for spec, held in self._known.items() if beyond(most, held)}
        if not suspects:
            return
        reach = extent(layout)
        for spec, held in suspects.items():
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


class ScoreWarnings:
    """Counts records with ``method``, ``layout``, ``outside`` and ``doubt``, one after the other.

    As :func:`steadyload.runs.scoring.score_layouts` and :func:`steadyload.app.checking.check`
    give them.
    """

    def __init__(self) -> None:
        self._of = Counter[str]()
        self._outside: dict[str, _Cases] = {}
        self._doubtful: dict[str, _Cases] = {}

    def add(self, record: Mapping[str, Any]) -> None:
        """Count a record."""
        spec, layout = record["method"], record["layout"]
        self._of[spec] += 1
        if record["outside"]:
            first = _Cases(layout, record["outside"][0])
            self._outside.setdefault(spec, first).count += 1
        elif record["doubt"]:
            self._doubtful.setdefault(spec, _Cases(layout, record["doubt"])).count += 1

    @property
    def sentences(self) -> list[str]:
        """The warnings of :func:`study_warnings` for the records counted.

        There is one more for each method that sees loads inside the envelope fall although they are
        in balance.
        """
        warnings = []
        for spec, of in self._of.items():
            if spec in self._outside:
                cases = self._outside[spec]
                warnings.append(_warning(spec, cases.count, of, cases.example, cases.sentence))
            if spec in self._doubtful:
                cases = self._doubtful[spec]
                warnings.append(
                    f"warning: {spec}: {cases.count} of {of} cases fail although the load is in "
                    f'balance; for example layout "{cases.example}": {cases.sentence}'
                )
        return warnings


@dataclass
class _Cases:
    """Cases of which the same is to be said, with the first of them as an example."""

    example: str
    sentence: str
    count: int = 0


def score_warnings(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """The sentences of :class:`ScoreWarnings` for some records."""
    counted = ScoreWarnings()
    for record in records:
        counted.add(record)
    return counted.sentences


def _warning(spec: str, cases: int, of: int, example: str, sentence: str) -> str:
    return (
        f"warning: {spec}: {cases} of {of} cases lie beyond what its engine was measured to hold; "
        f'for example layout "{example}": {sentence}'
    )
