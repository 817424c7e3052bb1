"""Names and other texts of users, made harmless where they are shown: one home for all ways."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

_SHOWN = 40
_LONGEST = 1_000
_MOST_BITS = 1023

_LONGEST_SENTENCE = 2_000
"""Characters of a sentence about what is wrong: values in it may come from anywhere."""

_MARKUP = re.compile(r"[\\`*\[\]<>|!#&~@]|(?<!\w)_|_(?!\w)|(?<=:)/(?=/)|(?<=www)\.")


def printable(text: str, most: int | None = None) -> str:
    """A text for a terminal: of control characters and the like their escapes.

    Args:
        text: any.
        most: number of characters of it that are shown; None for all.
    """
    cut = text if most is None or len(text) <= most else f"{text[: most - 3]}..."
    if cut.isprintable():
        return cut
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in cut)


def sentence(text: str) -> str:
    """A message as one printable line; of a long one the middle is left out.

    What is allowed mostly stands at the end, so that it is kept.
    """
    line = " ".join(text.split("\n")) if "\n" in text else text
    return _without_middle(printable(_without_middle(line)))


def _without_middle(line: str) -> str:
    if len(line) <= _LONGEST_SENTENCE:
        return line
    half = _LONGEST_SENTENCE // 2
    return f"{line[: half - 5]} ... {line[-half:]}"


def markdown(text: str) -> str:
    """A text for Markdown, and for HTML made of it: characters, and no markup, tag or link."""
    return _MARKUP.sub(r"\\\g<0>", printable(text))


def shown(value: Any, most: int = _SHOWN) -> str:
    """A value for a message, and "missing" if there is none; no more of it is rendered than shown.

    Args:
        value: any.
        most: number of characters.
    """
    if value is None:
        return "missing"
    text = ""
    for piece in _pieces(value):
        text += piece
        if len(text) > most:
            return f"{text[: most - 3]}..."
    return text


def _pieces(value: Any) -> Iterator[str]:
    """Text of a value as Python shows it, in pieces that are made as they are asked for."""
    if isinstance(value, str | bytes):
        yield ascii(value[:_LONGEST])
    elif isinstance(value, list | tuple):
        yield "[" if isinstance(value, list) else "("
        for index, element in enumerate(value):
            yield ", " if index else ""
            yield from _pieces(element)
        yield "]" if isinstance(value, list) else ")"
    elif isinstance(value, dict):
        yield "{"
        for index, (key, element) in enumerate(value.items()):
            yield ", " if index else ""
            yield from _pieces(key)
            yield ": "
            yield from _pieces(element)
        yield "}"
    elif isinstance(value, int) and value.bit_length() > _MOST_BITS:
        yield "a number of hundreds of digits"
    else:
        yield ascii(value)
