"""One-line faults in C, found by its signs, names and numbers: comments and texts have none."""

from __future__ import annotations

import re
from collections.abc import Iterator

_UNREAD = re.compile(r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M)
"""Comments, texts, and lines of the preprocessor with those that go on."""

_SIGNS = {
    "comparison": {
        " < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == ",
    },
    "sign": {
        " + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " += ": " -= ", " -= ": " += ",
    },
    "logic": {" && ": " || ", " || ": " && "},
}  # fmt: skip
"""With the spaces that stand around a sign between two values, and not around one of a type."""

_NAMES = {
    "lower": "upper", "upper": "lower", "least": "most", "most": "least", "starts": "ends",
    "ends": "starts", "true": "false", "false": "true",
}  # fmt: skip
_WHOLE = re.compile(r"(?<![\w.])[0-9](?![\w.])")
_NUMBER = re.compile(r"(?<![\w.])\d+\.\d+(?:e-?\d+)?(?![\w.])")
_CONDITION = re.compile(r"(?<!\w)if \((?=.*\)[^()]*$)")
_PAIR = re.compile(r"(?<=[(\s])([a-z_]\w*), ([a-z_]\w*)(?=[,)])")
_NEGATION = re.compile(r"(?<=[(\s])[!-](?=[\w(])")


def faults_in_c(source: str) -> Iterator[tuple[int, int, str, str, str]]:
    """Line, column in bytes, kind, text that is replaced, and the text in its place."""
    bare = _UNREAD.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), source)
    inside = False
    for number, line in enumerate(bare.split("\n"), 1):
        # Outside of functions there are declarations alone.
        if inside and not line.startswith("}"):
            for at, kind, before, after in _of_line(line):
                yield number, len(line[:at].encode()), kind, before, after
        inside = line.endswith("{") if line[:1].strip() and line[0] != "}" else inside
        inside = inside and not line.startswith("}")


def _of_line(line: str) -> Iterator[tuple[int, str, str, str]]:
    for kind, signs in _SIGNS.items():
        for before, after in signs.items():
            for found in re.finditer(re.escape(before), line):
                yield found.start(), kind, before, after
    for before, after in _NAMES.items():
        for found in re.finditer(rf"(?<!\w){before}(?!\w)", line):
            yield found.start(), "truth" if before in ("true", "false") else "name", before, after
    for found in _WHOLE.finditer(line):
        yield found.start(), "off by one", found[0], str(int(found[0]) + 1)
    for found in _NUMBER.finditer(line):
        yield found.start(), "number", found[0], repr(1.1 * float(found[0]) + 0.1)
    for found in _NEGATION.finditer(line):
        yield found.start(), "logic" if found[0] == "!" else "sign", found[0], ""
    for found in _PAIR.finditer(line):
        yield found.start(), "swap", found[0], f"{found[2]}, {found[1]}"
    for found in _CONDITION.finditer(line):
        if (end := _closed(line, found.end())) is not None:
            test = line[found.end() : end]
            yield found.end(), "condition", test, f"!({test})"


def _closed(line: str, start: int) -> int | None:
    """Where the parenthesis is closed that stands before a column; None where that is not here."""
    depth = 1
    for at in range(start, len(line)):
        depth += {"(": 1, ")": -1}.get(line[at], 0)
        if not depth:
            return at
    return None
