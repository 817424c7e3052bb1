"""A study's units of work: one method, and cases that it judges one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice
from typing import Any

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method, Status, Verdict, judge
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.labels import Case
from steadyload.runs.methods_here import method_named, use_methods
from steadyload.runs.pool import PartLimit
from steadyload.runs.provenance import key_of, made_by
from steadyload.runs.results import SCHEMA_VERSION, ResultsError, result_row, said_of

Row = dict[str, Any]
"""A row of :data:`steadyload.runs.results.SCHEMA`."""

MadeBy = Mapping[str, str]
"""Everything that a method's rows depend on: see :func:`steadyload.runs.provenance.made_by`."""


SHARD_SIZE, LARGEST, UNITS = 12, 100, 256
"""Cases of a unit of a study that does not say how many: of a small study, at most, and the units
of a method from which on they are more, so that workers have enough of them."""


class OtherCodeError(ResultsError):
    """A worker states other versions of its parts or packages than the process that started it."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of work: one method, the cases that it judges, and the key of its shard.

    A judgement is a repetition, a scenario and a layout; a row each.
    """

    method: str
    judgements: tuple[tuple[int, str, Layout], ...]
    key: str
    made_by: MadeBy
    timeout: float | None = None

    def __len__(self) -> int:
        return len(self.judgements)

    def without(self, done: int) -> Unit:
        """The unit without its first ``done`` judgements."""
        return replace(self, judgements=self.judgements[done:])

    def describe(self, part: int) -> str:
        """Description of a judgement for messages."""
        _, scenario, layout = self.judgements[part]
        return f"{self.method} on layout {layout.name!r} ({scenario})"


def made_now(methods: Iterable[Method]) -> dict[str, MadeBy]:
    """Everything that rows of methods depend on, by method, with the present code and packages.

    Args:
        methods: by which this process judges from now on, see :mod:`steadyload.runs.methods_here`.
    """
    chosen = list(methods)
    use_methods(chosen)
    _made_here.cache_clear()
    return {spec: _made_here(spec) for spec in map(str, chosen)}


@cache
def _made_here(spec: str) -> MadeBy:
    """Everything that a method's rows depend on in this process."""
    return made_by(method_named(spec))


def usual_size(cases: int) -> int:
    """Cases of a unit of a study that does not say how many.

    A shard takes time of its own, beside which the judgements of a dozen small layouts are short.

    Args:
        cases: of the study.
    """
    return min(max(SHARD_SIZE, cases // UNITS), LARGEST)


def study_units(
    study: StudyDefinition,
    cases: Iterable[Case],
    made_by: Mapping[str, MadeBy],
    size: int,
) -> Iterator[Unit]:
    """The units of a study, made lazily: every method on the first cases, then on the next.

    A unit's key is a hash of all that its rows depend on.

    Args:
        study: the definition of the study.
        cases: all cases, iterated once.
        made_by: everything that a method's rows depend on, by method that is to judge.
        size: cases of a unit.
    """
    ahead = iter(cases)
    while part := tuple(islice(ahead, size)):
        judgements = tuple(
            (repetition, scenario, layout)
            for repetition in range(study.repetitions)
            for scenario, layout in part
        )
        content = [[scenario, lay.name, lay.content_hash()] for scenario, lay in part]
        for method, made in made_by.items():
            key = verdicts_key(study, method, made, content)
            yield Unit(method, judgements, key, made, study.timeout)


def verdicts_key(
    study: StudyDefinition, method: str, made: MadeBy, cases: Sequence[Sequence[str]] | str
) -> str:
    """Key of the shard of a method on some cases: scenario, name and content hash of each, or the
    fingerprint of a block.
    """
    return key_of(
        {
            "question": "verdicts",
            "method": method,
            "made by": dict(made),
            "repetitions": study.repetitions,
            "timeout": study.timeout,
            "schema": SCHEMA_VERSION,
            "cases": cases,
        }
    )


def judge_unit(unit: Unit) -> Iterator[Row]:
    """Prepare a unit's method, then judge: a row of the results for every judgement, in turn.

    The first layout is judged once beforehand, so that no reported time holds imports, compilation
    or first connections; not so in a process that has judged by the method before, where that takes
    more than a millisecond.

    Raises:
        OtherCodeError: the versions of parts or packages here are not those that the unit states.
    """
    check_made_by(unit.method, unit.made_by)
    method = method_named(unit.method)
    method.prepare(max(len(layout) for _, _, layout in unit.judgements))
    return _rows(method, unit)


def check_made_by(method: str, asked: MadeBy) -> None:
    """Refuse to judge by something else than a unit states.

    Raises:
        OtherCodeError: the versions of parts or packages here are others.
    """
    here = _made_here(method)
    if asked != here:
        names = sorted({*asked, *here})
        other = [
            f"{name} {here.get(name, 'missing'):.16} instead of {asked.get(name, 'none'):.16}"
            for name in names
            if asked.get(name) != here.get(name)
        ]
        raise OtherCodeError(
            f"{method}: a worker would judge by {', '.join(other)}; allowed: the same on all "
            "workers, which are to be started anew when it was changed"
        )


def _rows(method: Method, unit: Unit) -> Iterator[Row]:
    first, said = _first_verdict(method, unit), said_of(method)
    for repetition, scenario, layout in unit.judgements:
        verdict, first = first or judge(method, layout, unit.timeout), None
        yield result_row(layout, scenario, said, repetition, verdict)


_LONG = 0.001
"""CPU time of a judgement beside which that of filling the processor's caches is small [s]."""

_judged_by: set[str] = set()
"""Methods by which this process has judged a layout."""


def _first_verdict(method: Method, unit: Unit) -> Verdict | None:
    """The verdict on the first layout; None where its time may hold more than the judgement."""
    verdict = judge(method, unit.judgements[0][2], unit.timeout)
    if unit.method in _judged_by and verdict.cpu.total > _LONG:
        return verdict
    _judged_by.add(unit.method)
    return None


def hard_seconds(timeout: float) -> float:
    """CPU time after which a judgement is ended from outside, such as in a call that hangs [s].

    A method looks at the clock between calls of its engine, so that a verdict may take longer than
    its ``timeout``; and the first judgement of a worker is made twice. Hence twice the timeout, and
    5 s more.

    Args:
        timeout: CPU seconds a judgement may take.
    """
    return 2.0 * timeout + 5.0


def hard_limit(timeout: float | None) -> PartLimit[Unit, Row] | None:
    """Hard limit of a judgement that may take some CPU seconds; None for no limit."""
    return None if timeout is None else PartLimit(hard_seconds(timeout), timed_out_row)


def crashed_row(unit: Unit, part: int, reason: str) -> Row:
    """The row of a judgement that ends the process it is made in."""
    return _row_without_verdict(unit, part, Status.CRASHED, reason)


def timed_out_row(unit: Unit, part: int, reason: str) -> Row:
    """The row of a judgement that exceeds its hard limit."""
    return _row_without_verdict(unit, part, Status.TIMEOUT, reason)


def _row_without_verdict(unit: Unit, part: int, status: Status, reason: str) -> Row:
    repetition, scenario, layout = unit.judgements[part]
    verdict = Verdict(item_count=len(layout), status=status, reason=reason)
    return result_row(layout, scenario, said_of(method_named(unit.method)), repetition, verdict)
