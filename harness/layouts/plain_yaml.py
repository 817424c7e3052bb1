"""YAML of plain values: what lets a small file grow without end is refused before it is built.

The events of a file come one after the other, in constant memory. Composing them is what recurses,
in C and without a limit, and aliases are what makes values many times larger than their text.
"""

from __future__ import annotations

from typing import Any

import yaml

from steadyload.layouts.record import FormatError, shown

try:
    from yaml import CSafeLoader as _Loader
except ImportError:  # PyYAML without libyaml
    from yaml import SafeLoader as _Loader

MOST_DEPTH = 32
"""How deep lists and objects may lie in each other; those of a schedule lie 8 deep."""

_MOST_BITS = 1023
"""Of a whole number: beyond it none is a float, and far beyond it none can be printed."""

_MERGE = "tag:yaml.org,2002:merge"


def parse_plain_yaml(text: str) -> Any:
    """The value that a text of YAML states.

    Raises:
        FormatError: it is none; or has an alias, a merge key, deeper nesting than
            :data:`MOST_DEPTH`, or a value that contradicts its type.
    """
    try:
        _refuse_growth(text)
        return yaml.load(text, Loader=_PlainLoader)  # noqa: S506 - of safe values, and stricter
    except yaml.constructor.ConstructorError as error:
        said = f": {error.note}" if error.note else ""
        raise FormatError(
            f"holds a YAML value that is none{_place(error)}{said}; allowed: texts, numbers, truth "
            "values, times, lists and objects"
        ) from None
    except yaml.YAMLError as error:
        raise FormatError(f"is not valid YAML{_place(error)}; is it cut off?") from None


def _place(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    return f" at line {mark.line + 1}" if mark else ""


def _refuse_growth(text: str) -> None:
    """Walk the events up to the first that is not allowed."""
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MOST_DEPTH:
                raise _refusal(event, "is nested too deeply", f"{MOST_DEPTH} levels")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.AliasEvent):
            raise _refusal(event, f"has the alias *{event.anchor[:40]}", "values written out")
        elif isinstance(event, yaml.ScalarEvent) and _merges(event):
            raise _refusal(event, "has the merge key <<", "values written out")


def _merges(event: yaml.ScalarEvent) -> bool:
    return event.tag == _MERGE or (event.value == "<<" and event.implicit[0])


def _refusal(event: yaml.Event, what: str, allowed: str) -> FormatError:
    return FormatError(f"{what} at line {event.start_mark.line + 1}; allowed: {allowed}")


class _PlainLoader(_Loader):
    """Adds its place in the file to the error of every value that cannot be built."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """See PyYAML, whose constructors raise whatever a text leads to."""
        try:
            value = super().construct_object(node, deep)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            raise _no_value(node) from None
        if isinstance(value, int) and value.bit_length() > _MOST_BITS:
            raise _no_value(node)
        return value


def _no_value(node: yaml.Node) -> yaml.constructor.ConstructorError:
    value = shown(node.value) if isinstance(node, yaml.ScalarNode) else "what stands there"
    note = f"{value} is no {ascii(node.tag.rpartition(':')[2]).strip(chr(39))}"
    return yaml.constructor.ConstructorError(problem_mark=node.start_mark, note=note)
