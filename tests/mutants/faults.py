"""One-line faults, drawn by a seeded rule over the syntax tree of Python, and over lines of C."""

from __future__ import annotations

import ast
import itertools
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from faults_in_c import faults_in_c

_COMPARISONS = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
}  # fmt: skip
_SIGNS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
_NAMES = {
    "mean": "median", "median": "mean", "min": "max", "max": "min", "minimum": "maximum",
    "maximum": "minimum", "argmin": "argmax", "argmax": "argmin", "any": "all", "all": "any",
    "floor": "ceil", "ceil": "floor", "lower": "upper", "upper": "lower", "cpu": "wall",
    "x": "z", "z": "x", "width": "depth", "depth": "width",
}  # fmt: skip
"""Of functions, axes and ends: one is written where the other is meant."""

_UNITS = (1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3, 1e6)
"""Factors between units."""


@dataclass(frozen=True, order=True)
class Fault:
    """A fault in one line.

    Attributes:
        path: of the file, from the root of the project.
        line: from 1.
        kind: of the fault, in a word or two.
        column: from 0, in bytes.
        before: the text that is replaced.
        after: what stands in its place.
    """

    path: str
    line: int
    column: int
    kind: str
    before: str
    after: str

    @property
    def key(self) -> str:
        """The fault in a line, wherever in its file it stands."""
        return f"{self.path}: {self.kind}: {self.before} -> {self.after}"

    def planted(self, source: str) -> str:
        """The source of its file with the fault.

        Raises:
            ValueError: what it replaces does not stand there.
        """
        lines = source.encode().split(b"\n")
        line, old = lines[self.line - 1], self.before.encode()
        if line[self.column : self.column + len(old)] != old:
            raise ValueError(f"{self.path}:{self.line}: {self.before!r} does not stand there")
        end = self.column + len(old)
        lines[self.line - 1] = line[: self.column] + self.after.encode() + line[end:]
        return b"\n".join(lines).decode()


def faults_in(path: str, source: str) -> Iterator[Fault]:
    """All faults that the rule knows of a file, in the order of its lines.

    Texts, annotations, imports and messages of errors have none.
    """
    if path.endswith(".c"):
        yield from sorted({Fault(path, *found) for found in faults_in_c(source)})
        return
    reader = _Reader(path, source)
    reader.visit(ast.parse(source))
    yield from sorted(set(reader.found))


def drawn(files: list[tuple[str, str]], count: int, seed: int) -> list[Fault]:
    """So many faults of some files, each kind as often as the others as far as there are enough.

    Args:
        files: path and source of each.
        count: of faults, at most.
        seed: of the draw: the same one draws the same faults from the same files.
    """
    kinds: dict[str, list[Fault]] = {}
    for path, source in files:
        for fault in faults_in(path, source):
            kinds.setdefault(fault.kind, []).append(fault)
    draw, found = random.Random(seed), list[Fault]()
    for own in kinds.values():
        draw.shuffle(own)
    names = sorted(kinds)
    draw.shuffle(names)
    while len(found) < count and names:
        for name in list(names):
            if len(found) < count:
                found.append(kinds[name].pop())
            if not kinds[name]:
                names.remove(name)
    return sorted(found)


def source_files(root: Path, room: str) -> list[tuple[str, str]]:
    """Path from the root and source of the files of a room: a pattern of files, or a folder with
    its Python.
    """
    files = sorted(root.glob(room) if "*" in room else (root / room).rglob("*.py"))
    return [(str(file.relative_to(root)), file.read_text()) for file in files]


class _Reader(ast.NodeVisitor):
    def __init__(self, path: str, source: str) -> None:
        self._path = path
        self._lines = source.encode().split(b"\n")
        self.found: list[Fault] = []

    def _fault(self, kind: str, line: int, start: int, end: int, after: str) -> None:
        before = self._lines[line - 1][start:end].decode()
        if before and before != after:
            self.found.append(Fault(self._path, line, start, kind, before, after))

    def _between(self, left: ast.expr, right: ast.expr, kind: str, sign: str, after: str) -> None:
        """Replace a sign that stands between two expressions in one line."""
        if left.end_lineno != right.lineno or left.end_col_offset is None:
            return
        gap = self._lines[right.lineno - 1][left.end_col_offset : right.col_offset].decode()
        if gap.count(sign) == 1:
            at = left.end_col_offset + gap.index(sign)
            self._fault(kind, right.lineno, at, at + len(sign), after)

    def visit_Compare(self, node: ast.Compare) -> None:
        sides = [node.left, *node.comparators]
        for left, operator, right in zip(sides, node.ops, sides[1:], strict=False):
            if (after := _COMPARISONS.get(type(operator))) is not None:
                sign = _SIGN_OF[type(operator)]
                self._between(left, right, "comparison", sign, after)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not _is_text(node.left) and not _is_text(node.right):
            if (after := _SIGNS.get(type(node.op))) is not None:
                self._between(node.left, node.right, "sign", _SIGN_OF[type(node.op)], after)
            self._unit(node)
        self.generic_visit(node)

    def _unit(self, node: ast.BinOp) -> None:
        """A factor between units is lost."""
        if not isinstance(node.op, ast.Mult) or node.lineno != node.end_lineno:
            return
        for side, kept in ((node.left, node.right), (node.right, node.left)):
            if isinstance(side, ast.Constant) and side.value in _UNITS:
                text = self._lines[kept.lineno - 1][kept.col_offset : kept.end_col_offset]
                self._fault("unit", node.lineno, node.col_offset, node.end_col_offset or 0,
                            text.decode())  # fmt: skip

    def visit_Constant(self, node: ast.Constant) -> None:
        value, end = node.value, node.end_col_offset or 0
        if type(value) is int and 0 <= value < 10:
            self._fault("off by one", node.lineno, node.col_offset, end, str(value + 1))
        elif type(value) is float and value not in _UNITS:
            self._fault("number", node.lineno, node.col_offset, end, repr(1.1 * value + 0.1))
        elif type(value) is bool:
            self._fault("truth", node.lineno, node.col_offset, end, str(not value))

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        word, after = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in itertools.pairwise(node.values):
            self._between(left, right, "logic", word, after)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.Not | ast.USub):
            kind, word = ("logic", "not") if isinstance(node.op, ast.Not) else ("sign", "-")
            end = node.col_offset + len(word)
            self._fault(kind, node.lineno, node.col_offset, end, "")
        self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        self._turned(node.test)
        self.generic_visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._turned(node.test)
        self.generic_visit(node)

    def _turned(self, test: ast.expr) -> None:
        if test.lineno == test.end_lineno and not isinstance(test, ast.NamedExpr):
            text = self._lines[test.lineno - 1][test.col_offset : test.end_col_offset].decode()
            self._fault("condition", test.lineno, test.col_offset, test.end_col_offset or 0,
                        f"(not ({text}))")  # fmt: skip

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if (after := _NAMES.get(node.attr)) is not None and node.end_col_offset is not None:
            line = node.end_lineno or node.lineno
            self._fault("name", line, node.end_col_offset - len(node.attr), node.end_col_offset,
                        after)  # fmt: skip
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        if isinstance(node.func, ast.Name) and (after := _NAMES.get(node.func.id)) is not None:
            end = node.func.end_col_offset or 0
            self._fault("name", node.func.lineno, node.func.col_offset, end, after)
        for keyword in node.keywords:
            if keyword.arg is not None and len(node.keywords) > 1:
                self._dropped(keyword.lineno, keyword.col_offset, keyword.end_lineno or 0,
                              keyword.end_col_offset or 0, "argument")  # fmt: skip
        self._swapped(node.args)
        if isinstance(node.func, ast.Name) and node.func.id.endswith("Error"):
            return  # what an error says
        self.generic_visit(node)

    def _swapped(self, arguments: list[ast.expr]) -> None:
        """Two arguments beside each other change places."""
        for left, right in itertools.pairwise(arguments):
            if not isinstance(left, ast.Name) or not isinstance(right, ast.Name):
                continue
            if left.lineno == right.lineno:
                self._fault("swap", left.lineno, left.col_offset, right.end_col_offset or 0,
                            f"{right.id}, {left.id}")  # fmt: skip

    def visit_Dict(self, node: ast.Dict) -> None:
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and isinstance(key.value, str) and len(node.keys) > 1:
                self._dropped(key.lineno, key.col_offset, value.end_lineno or 0,
                              value.end_col_offset or 0, "field")  # fmt: skip
        self.generic_visit(node)

    def _dropped(self, line: int, start: int, last: int, end: int, kind: str) -> None:
        """A part of a list of parts is lost, with the comma behind it."""
        if line == last and self._lines[line - 1][end : end + 1] == b",":
            self._fault(kind, line, start, end + 1, "")

    def visit_Raise(self, node: ast.Raise) -> None:
        """An error says what it says."""

    def visit_Assert(self, node: ast.Assert) -> None:
        """What never fails is no test of anything."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """A text is no fault."""

    def visit_Import(self, node: ast.Import) -> None:
        """Nothing to change."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_arg(self, node: ast.arg) -> None:
        """An annotation is no code."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for part in (*node.decorator_list, node.args, *node.body):
            self.visit(part)


_SIGN_OF = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
}  # fmt: skip


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
