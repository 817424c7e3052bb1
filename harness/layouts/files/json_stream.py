"""JSON that is read value by value: what lies in memory at a time has a limit, whatever the file.

Only the values of one object at the top, and the elements of its lists where asked for, are told
apart here; each is parsed by the standard library. Positions are kept for messages.
"""

from __future__ import annotations

import codecs
import json
import re
from collections.abc import Iterable, Iterator
from typing import Any

from steadyload.layouts.files.limits import MAX_STREAM_BYTES, MAX_VALUE_LENGTH
from steadyload.layouts.files.record import FormatError, shown

_SPACE = re.compile(r"[ \t\n\r]*")
_MOST_MEMBERS = 1_000
_LONGEST_TOKEN = 16
"""An error this near the end of what is read may only mean that more has to be read; a text, whose
error stands at its beginning, is told by the error's words."""


class JsonText:
    """A text of JSON that is read as far as it is asked for.

    Args:
        chunks: the bytes of a file, in turn.
        most: number of bytes that are read.

    Raises:
        FormatError: from all functions: it is no UTF-8, no JSON, or larger than allowed.
    """

    def __init__(self, chunks: Iterable[bytes], most: int = MAX_STREAM_BYTES) -> None:
        self._chunks, self._most = iter(chunks), most
        self._decoder = codecs.getincrementaldecoder("utf-8-sig")()
        self._text, self._at = "", 0
        self._line, self._column, self._bytes, self._ended = 1, 0, 0, False

    def next_character(self) -> str:
        """The next one that is no white space, which stays to be read; empty at the end."""
        while True:
            found = _SPACE.match(self._text, self._at)
            self._at = found.end() if found else self._at
            if self._at < len(self._text):
                return self._text[self._at]
            if self._ended:
                return ""
            self._read_more()

    def take(self, allowed: str) -> str:
        """The next character, which has to be one of those allowed."""
        character = self.next_character()
        if not character or character not in allowed:
            names = " or ".join(repr(one) for one in allowed)
            raise self._invalid(f"Expecting {names}", self._at)
        self._at += 1
        return character

    def end(self) -> None:
        """Refuse anything that follows."""
        if self.next_character():
            raise self._invalid("Extra data", self._at)

    def value(self) -> Any:
        """The next value, of whatever kind."""
        self.next_character()
        while True:
            place = self._at
            try:
                value, end = _DECODER.raw_decode(self._text, self._at)
                # A number may go on.
                if end < len(self._text) or self._ended:
                    self._at = end
                    return value
            except json.JSONDecodeError as error:
                place = error.pos
                if self._ended or not self._may_go_on(error):
                    raise self._invalid(error.msg, error.pos) from None
            except RecursionError:
                raise FormatError("is not a layout file: its JSON is nested too deeply") from None
            except FormatError:
                raise
            except ValueError as error:
                # Python refuses to convert integers of thousands of digits.
                raise FormatError(f"holds a number that is none ({error})") from None
            if len(self._text) - self._at > MAX_VALUE_LENGTH:
                raise self._invalid(f"a value of more than {MAX_VALUE_LENGTH:,} characters", place)
            self._read_more()

    def _may_go_on(self, error: json.JSONDecodeError) -> bool:
        near = error.pos >= len(self._text) - _LONGEST_TOKEN
        return near or error.msg.startswith("Unterminated string")

    def _read_more(self) -> None:
        """As much again as there is, so that all attempts at a value cost twice the last one."""
        self._line, self._column = self._place(self._at)
        parts = [self._text[self._at :]]
        wanted, read = max(1, len(parts[0])), 0
        while read < wanted and not self._ended:
            chunk = next(self._chunks, b"")
            try:
                parts.append(self._decoder.decode(chunk, final=not chunk))
            except UnicodeDecodeError as error:
                # The decoder counts from the bytes of a character that the last chunk began.
                start = self._bytes - (len(error.object) - len(chunk)) + error.start
                raise FormatError(f"is not UTF-8 text (byte {start})") from None
            self._ended = not chunk
            self._bytes += len(chunk)
            read += len(chunk)
            if self._bytes > self._most:
                raise FormatError(
                    f"has more than {self._most // 1024**2:,} MiB; that is the most allowed"
                )
        self._text, self._at = "".join(parts), 0

    def limit(self, most: int) -> None:
        """Allow less to be read from here on."""
        self._most = min(self._most, most)

    def _place(self, at: int) -> tuple[int, int]:
        """Line, from 1, and column, from 0, of a position."""
        lines = self._text.count("\n", 0, at)
        if not lines:
            return self._line, self._column + at
        return self._line + lines, at - self._text.rindex("\n", 0, at) - 1

    def _invalid(self, what: str, at: int) -> FormatError:
        line, column = self._place(at)
        return FormatError(
            f"is not valid JSON ({what} at line {line}, column {column + 1}); is it cut off?"
        )


class Elements:
    """The elements of a list that is being read: one after the other, once, to the end."""

    def __init__(self, text: JsonText) -> None:
        self._text = text

    def __iter__(self) -> Iterator[Any]:
        self._text.take("[")
        if self._text.next_character() == "]":
            self._text.take("]")
            return
        yield self._text.value()
        while self._text.take(",]") == ",":
            yield self._text.value()


def members(text: JsonText, streamed: Iterable[str]) -> Iterator[tuple[str, Any]]:
    """Names and values of the object that a text is, in the order of the text.

    Args:
        text: it.
        streamed: names whose value, where it is a list, is handed out as :class:`Elements`; these
            have to be read before the next member is asked for.
    """
    names: set[str] = set()
    text.take("{")
    if text.next_character() == "}":
        text.take("}")
        return text.end()
    while True:
        name = _name(text)
        if name in names:
            raise _twice(name)
        if len(names) == _MOST_MEMBERS:
            raise FormatError(f"has more than {_MOST_MEMBERS:,} keys; that is the most allowed")
        names.add(name)
        text.take(":")
        list_follows = name in streamed and text.next_character() == "["
        yield name, Elements(text) if list_follows else text.value()
        if text.take(",}") == "}":
            return text.end()


def _name(text: JsonText) -> str:
    if text.next_character() != '"':
        text.take('"')
    return text.value()


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        seen: set[str] = set()
        for name, _ in pairs:
            if name in seen:
                raise _twice(name)
            seen.add(name)
    return values


def _twice(name: str) -> FormatError:
    return FormatError(f"states {shown(name)} twice in one object; allowed: each name once")


_DECODER = json.JSONDecoder(object_pairs_hook=_without_duplicates)
