"""YAML of plain values: what lets a small file grow without end is refused before it is built.

The events of a file come one after the other, in constant memory. Composing them is what recurses,
in C and without a limit, and aliases are what makes values many times larger than their text.
"""

from __future__ import annotations

from typing import Any

import yaml

from steadyload.layouts.files.limits import MAX_DEPTH, MAX_TEXT_LENGTH, MAX_YAML_VALUES
from steadyload.layouts.files.record import FormatError, shown

try:
    from yaml import CSafeDumper as _Dumper
    from yaml import CSafeLoader as _Loader
except ImportError:  # PyYAML without libyaml
    from yaml import SafeDumper as _Dumper
    from yaml import SafeLoader as _Loader

_MOST_BITS = 1023
"""Of a whole number: beyond it none is a float, and far beyond it none can be printed."""

_LONGEST_KEY = 18
"""Characters of a key that is a number: many longer whole numbers can share one hash."""

_MERGE = "tag:yaml.org,2002:merge"


def parse_plain_yaml(text: str) -> Any:
    """The value that a text of YAML states.

    Raises:
        FormatError: it is none; or has an alias, a merge key, deeper nesting than
            :data:`MAX_DEPTH`, or a value that contradicts its type.
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


def composed(text: str) -> yaml.Node:
    """The nodes of what :func:`parse_plain_yaml` accepts."""
    return yaml.compose(text, Loader=_Loader)


def serialized(node: yaml.Node) -> str:
    """The text of such nodes, in which texts and numbers stand as they were read."""
    text: str = yaml.serialize(node, Dumper=_Dumper, width=10 * MAX_TEXT_LENGTH, allow_unicode=True)
    return text


def _place(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    return f" at line {mark.line + 1}" if mark else ""


def _refuse_growth(text: str) -> None:
    """Walk the events up to the first that is not allowed."""
    depth = values = 0
    for event in yaml.parse(text, Loader=_Loader):
        values += isinstance(event, yaml.NodeEvent)
        if values > MAX_YAML_VALUES:
            raise _refusal(event, "holds too much", f"{MAX_YAML_VALUES:,} values")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MAX_DEPTH:
                raise _refusal(event, "is nested too deeply", f"{MAX_DEPTH} levels")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.AliasEvent):
            raise _refusal(event, f"has the alias *{event.anchor[:40]}", "values written out")
        elif isinstance(event, yaml.ScalarEvent):
            _refuse_long(event)
            if _merges(event):
                raise _refusal(event, "has the merge key <<", "values written out")


def _refuse_long(event: yaml.ScalarEvent) -> None:
    """A long number or time costs as much as thousands; some grow with the square of the length."""
    if len(event.value) > MAX_TEXT_LENGTH:
        raise FormatError(
            f"holds a YAML value that is none at line {event.start_mark.line + 1}: "
            f"{shown(event.value)} has {len(event.value):,} characters; allowed: at most "
            f"{MAX_TEXT_LENGTH:,}"
        )


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

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """See PyYAML; refuses keys whose table may take the square of their number."""
        for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            number = isinstance(key, yaml.ScalarNode) and key.tag.endswith(":int")
            if number and len(key.value) > _LONGEST_KEY:
                raise _no_value(key)
        return super().construct_mapping(node, deep)


def _no_value(node: yaml.Node) -> yaml.constructor.ConstructorError:
    value = shown(node.value) if isinstance(node, yaml.ScalarNode) else "what stands there"
    note = f"{value} is no {ascii(node.tag.rpartition(':')[2]).strip(chr(39))}"
    return yaml.constructor.ConstructorError(problem_mark=node.start_mark, note=note)
