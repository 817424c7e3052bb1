"""Which cases a study or a score asks of an engine beyond what that was measured to hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from harness.layouts.model import Layout
from harness.methods.envelope import Extent, Limit, beyond, envelope_of, extent
from harness.methods.registry import make_method

EnvelopeUse = dict[str, dict[str, Any]]
"""By method: ``measured``; where that is true also ``cases`` beyond the envelope, ``of`` how many,
and ``reasons``, the most frequent first: ``limit``, ``cases``, the first one as ``example``, and
the ``sentence`` that says how far it goes."""


def envelope_use(methods: Iterable[str], cases: Sequence[tuple[str, Layout]]) -> EnvelopeUse:
    """What a manifest says of envelopes: methods without an engine are left out.

    Args:
        methods: spec strings.
        cases: scenario and layout.
    """
    use: EnvelopeUse = {}
    extents: list[Extent] = []
    for spec in methods:
        method = make_method(spec)
        if method.spec.engine is None:
            continue
        held = envelope_of(method)
        if held is None:
            use[spec] = {"measured": False}
            continue
        extents = extents or [extent(layout) for _, layout in cases]
        found = [beyond(one, held) for one in extents]
        named = [(said, layout.name) for said, (_, layout) in zip(found, cases, strict=True)]
        reasons = [reason for limit in Limit if (reason := _reason(limit, named))]
        use[spec] = {
            "measured": True,
            "cases": sum(map(bool, found)),
            "of": len(cases),
            "reasons": sorted(reasons, key=lambda r: -r["cases"]),
        }
    return use


def _reason(
    limit: Limit, found: Sequence[tuple[Mapping[Limit, str], str]]
) -> dict[str, Any] | None:
    sentences = [(name, said[limit]) for said, name in found if limit in said]
    if not sentences:
        return None
    name, sentence = sentences[0]
    return {
        "limit": str(limit), "cases": len(sentences), "example": name, "sentence": sentence
    }  # fmt: skip


def study_warnings(use: EnvelopeUse) -> list[str]:
    """A sentence for each method that is asked beyond its envelope."""
    return [
        _warning(spec, entry["cases"], entry["of"], first["example"], first["sentence"])
        for spec, entry in use.items()
        for first in entry.get("reasons", [])[:1]
    ]


def score_warnings(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """The same of the records that :func:`harness.studies.scoring.score_layouts` returns."""
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
    return warnings


def _warning(spec: str, cases: int, of: int, example: str, sentence: str) -> str:
    return (
        f"warning: {spec}: {cases} of {of} cases lie beyond what its engine was measured to hold; "
        f'for example layout "{example}": {sentence}'
    )
