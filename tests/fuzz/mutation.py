"""Structured mutation: small, odd and hostile changes of a valid file, drawn at random."""

import copy
import json
import random
import re
from collections.abc import Callable, Sequence

TOKEN = re.compile(rb'"(?:[^"\\]|\\.)*"|[-+.\w]+|\s+|.', re.S)

ODD: Sequence[bytes] = (
    b"0", b"-0", b"-1", b"1e999", b"-1e999", b"1e-999", b"NaN", b"nan", b"inf", b"-inf",
    b"Infinity",
    b"9" * 30, b"9" * 400, b"9" * 5000, b"0x" + b"f" * 300, b"9223372036854775808", b"1_000", b"1.",
    b".5", b"0.1.2", b"true", b"True", b"false", b"null", b"~", b"None", b'""', b"''", b'"\\u0000"',
    b'"\\u001b[2J"', b'"\\ud800"', b'"' + b"a" * 3000 + b'"', "\u202e\u00e9\U0001f600".encode(),
    b"[]", b"{}", b"[[]]", b"{\"a\": 1}", b"[1, 2, 3]", b"[" * 3000, b"{" * 60,
    b'{"a":' * 2000, b"]",
    b"}", b",", b":", b"=", b"\n", b"\t", b"- ", b"&a ", b"*a", b"<<: ", b"!!int ", b"!!binary ",
    b"!!timestamp ", b"!!set ", b"!!python/object:os.system ", b"? ", b"|\n", b"1:1:1:1",
    b"'''", b'"""',
    b"2001-01-01T00:00:00+99:00", b"2001-01-01", b"#", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\r",
    b"=cmd()", b"@x", b"\x1b]0;x\x07", b"../../../etc/passwd", b"/dev/null", b"%s%n", b"<script>",
)  # fmt: skip
"""Tokens that have broken readers, or might."""

VALUES: Sequence[object] = (
    None, True, False, 0, -1, 2**31, 2**63, 2**64, 10**30, 0.5, 1e308, float("nan"), float("inf"),
    "",
    "a", "\x1b[2J", "\ud800", "x" * 3000, "1e5", [], {}, [[]], [None], {"": None}, [1, 2, 3],
    ["a", "b"], {"a": {"b": []}}, [0] * 3000,
)  # fmt: skip


def mutated(content: bytes, draw: random.Random) -> bytes:
    """A text or binary file with one to four changes."""
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        content = draw.choice(_CHANGES)(content, draw)
    return content


def mutated_json(content: bytes, draw: random.Random) -> bytes:
    """A file of JSON whose values are changed in their places, or its text."""
    if draw.random() < 0.4:
        return mutated(content, draw)
    whole = json.loads(content)
    for _ in range(draw.choice((1, 1, 2, 3))):
        _change_value(whole, draw)
    return json.dumps(whole).encode("utf-8", errors="replace")


def _change_value(value: object, draw: random.Random) -> None:
    """Go down at random, and replace, remove, double or rename what lies there."""
    while isinstance(value, dict | list) and value:
        key = draw.choice(list(value)) if isinstance(value, dict) else draw.randrange(len(value))
        below = value[key]  # type: ignore[index]
        if isinstance(below, dict | list) and below and draw.random() < 0.75:
            value = below
            continue
        kind = draw.randrange(6)
        if kind == 0:
            del value[key]  # type: ignore[arg-type]
        elif kind == 1 and isinstance(value, list):
            value += value[: 2 * draw.randrange(1, 3000)] * draw.choice((1, 1, 3))
        elif kind == 1 and isinstance(value, dict):
            value[draw.choice(("", "x", "\x1b[31m", "a" * 2000, "name"))] = value.pop(key)
        elif kind == 2 and isinstance(below, int | float) and not isinstance(below, bool):
            value[key] = below * draw.choice((-1, 0, 1e-300, 0.5, 1e3, 1e9, 1e300))  # type: ignore[index]
        else:
            value[key] = copy.deepcopy(draw.choice(VALUES))  # type: ignore[index]
        return


def _flip(content: bytes, draw: random.Random) -> bytes:
    if not content:
        return content
    place, changed = draw.randrange(len(content)), bytearray(content)
    changed[place] ^= 1 << draw.randrange(8)
    return bytes(changed)


def _cut(content: bytes, draw: random.Random) -> bytes:
    first, last = sorted(draw.randrange(len(content) + 1) for _ in range(2))
    return content[:first] if draw.random() < 0.5 else content[:first] + content[last:]


def _double(content: bytes, draw: random.Random) -> bytes:
    first = draw.randrange(len(content) + 1)
    last = min(len(content), first + draw.choice((1, 10, 100, 1000)))
    return content[:last] + content[first:last] * draw.choice((1, 2, 30)) + content[last:]


def _odd_token(content: bytes, draw: random.Random) -> bytes:
    tokens = [found.span() for found in TOKEN.finditer(content) if not found[0].isspace()]
    if not tokens:
        return draw.choice(ODD)
    first, last = draw.choice(tokens)
    return content[:first] + draw.choice(ODD) + content[last if draw.random() < 0.8 else first :]


def _swap(content: bytes, draw: random.Random) -> bytes:
    tokens = [found.span() for found in TOKEN.finditer(content) if not found[0].isspace()]
    if len(tokens) < 2:
        return content
    (a, b), (c, d) = sorted(draw.sample(tokens, 2))
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def _swap_lines(content: bytes, draw: random.Random) -> bytes:
    lines = content.split(b"\n")
    one, other = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


_CHANGES: Sequence[Callable[[bytes, random.Random], bytes]] = (
    _flip, _cut, _double, _odd_token, _odd_token, _odd_token, _swap, _swap_lines,
)  # fmt: skip
