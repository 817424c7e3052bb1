"""Names that the template of a page takes of records, checked against the types of these.

A rendering finds a wrong name only in the branches that it takes; here all are looked at.
"""

import ast
import dataclasses
import importlib
import inspect
import sys
import types
import typing
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import jinja2
from jinja2 import meta, nodes

from steadyload.reports.charts.kinds import KINDS
from steadyload.reports.frame_columns import COLUMNS

_KEEPING = {"sort", "list", "reverse", "selectattr", "rejectattr", "unique"}
"""Filters whose result has the elements of what they are given."""

_PICKING = {"first", "last", "min", "max", "random"}
"""Filters whose result is an element of what they are given."""

_BY_ATTRIBUTE = {"selectattr", "rejectattr"}
"""Filters whose first argument is the name of an attribute of the elements."""

_PAGE = {"found", "study"}


def found_type(study):
    """The class of the results of a study, which its module may import for types alone."""
    names = {}
    for node in ast.walk(ast.parse(inspect.getsource(sys.modules[study.__module__]))):
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            for alias in node.names:
                module = importlib.import_module(node.module)
                names[alias.asname or alias.name] = getattr(module, alias.name, None)
    return typing.get_type_hints(study.run, localns=names)["return"]


def wrong_names(template, environment, **of):
    """Faults of a template, with their lines.

    Args:
        template: its text.
        environment: of Jinja, with the filters and functions of pages.
        of: types of what the page names, such as ``found``; where that is a namespace, tables are
            of frames, and their columns are those of the registry.
    """
    try:
        tree = environment.parse(template)
        environment.compile(template)
    except jinja2.TemplateSyntaxError as error:
        return [f"line {error.lineno}: {error.message}"]
    known = _PAGE | environment.globals.keys()
    # What Jinja finds itself folds constants in the tree that it is given.
    unknown = meta.find_undeclared_variables(environment.parse(template)) - known
    faults = [f"nothing is named {name}" for name in sorted(unknown)]
    checker = _Checker(of_frames=issubclass(of.get("found") or object, types.SimpleNamespace))
    checker.walk(tree, dict(of))
    return faults + list(dict.fromkeys(checker.faults))


def faults_of(study, environment_of):
    """Faults of the template of a study."""
    template = Path(inspect.getfile(study)).with_name("page.md.j2")
    environment = environment_of(template.parent, [])
    return wrong_names(template.read_text(), environment, found=found_type(study), study=study)


class _Checker:
    def __init__(self, *, of_frames=False):
        self.faults, self.of_frames = [], of_frames

    def walk(self, node, scope):
        match node:
            case nodes.For():
                self.walk(node.iter, scope)
                inner = dict(scope)
                self._bind(node.target, _element(self.type_of(node.iter, scope)), inner)
                for part in (*filter(None, [node.test]), *node.body, *node.else_):
                    self.walk(part, inner)
                return
            case nodes.Macro() | nodes.CallBlock():
                inner = dict(scope)
                for name in node.args:
                    inner.pop(name.name, None)
                if isinstance(node, nodes.CallBlock):
                    self.walk(node.call, scope)
                for part in node.body:
                    self.walk(part, inner)
                return
            case nodes.Assign():
                self.walk(node.node, scope)
                self._bind(node.target, self.type_of(node.node, scope), scope)
                return
            case nodes.Getattr():
                self.attribute(self.type_of(node.node, scope), node.attr, node.lineno)
            case nodes.CondExpr() if node.expr2 is None:
                self.faults.append(f"line {node.lineno}: if without else writes an undefined value")
            case nodes.Filter():
                self._filter(node, scope)
            case nodes.Call(node=nodes.Name(name="table")):
                self._table(node, scope)
            case nodes.Call(node=nodes.Name(name=kind)) if kind in KINDS:
                self._chart(KINDS[kind], node, scope)
        for part in node.iter_child_nodes():
            self.walk(part, scope)

    def attribute(self, of, name, line):
        """The type of an attribute; a fault where a record has none of the name."""
        of = _plain(of)
        is_free = isinstance(of, type) and issubclass(of, types.SimpleNamespace)
        if not is_free and not _is_record(of):
            return None
        hints = typing.get_type_hints(of)
        if name in hints:
            return hints[name]
        found = inspect.getattr_static(of, name, None)
        if found is None and not is_free:
            self.faults.append(f"line {line}: {of.__name__} has no {name}")
            return None
        getter = found.fget if isinstance(found, property) else getattr(found, "func", None)
        return typing.get_type_hints(getter).get("return") if getter else None

    def path(self, of, names, line):
        for name in names.split("."):
            of = self.attribute(of, name, line)
        return of

    def _bind(self, target, kind, scope):
        if isinstance(target, nodes.Name):
            scope[target.name] = kind
        elif isinstance(target, nodes.Tuple):
            kinds = typing.get_args(kind) if typing.get_origin(kind) is tuple else ()
            for k, one in enumerate(target.items):
                self._bind(one, kinds[k] if k < len(kinds) and ... not in kinds else None, scope)

    def _filter(self, node, scope):
        of = _element(self.type_of(node.node, scope)) if node.node is not None else None
        said = [k.value for k in node.kwargs if k.key == "attribute"]
        said += node.args[:1] if node.name in _BY_ATTRIBUTE | {"groupby"} else []
        for name in said:
            if isinstance(name, nodes.Const):
                for one in str(name.value).split(","):
                    self.path(of, one, node.lineno)

    def _table(self, node, scope):
        """Columns that a table names."""
        of = _element(self.type_of(node.args[0], scope))
        if of is None and self.of_frames and len(node.args) > 1:
            for text in (t for arg in node.args[1:2] for t in _constants(arg)):
                for name in text.split():
                    if name.partition(".")[0].partition(":")[0] not in COLUMNS:
                        self.faults.append(f"line {node.lineno}: no column {name}")
        chosen = [*node.args[1:2], *(k.value for k in node.kwargs if k.key == "chosen")]
        titles = [*node.args[2:3], *(k.value for k in node.kwargs if k.key == "titles")]
        names = [n for c in chosen if isinstance(c, nodes.Const) for n in c.value.split()]
        for title in titles:
            if isinstance(title, nodes.Dict):
                names += [p.key.value for p in title.items if isinstance(p.key, nodes.Const)]
        for name in names:
            self.path(of, name, node.lineno)

    def _chart(self, kind, node, scope):
        """Fields that a chart names, those that it takes by default among them."""
        _, rows, *positional = node.args
        of = _element(self.type_of(rows, scope))
        stated = inspect.signature(kind).bind(
            rows, *positional, **{k.key: k.value for k in node.kwargs}
        )
        stated.apply_defaults()
        named = [
            name
            for parameter, argument in stated.arguments.items()
            if "Field" in str(stated.signature.parameters[parameter].annotation)
            for name in _texts(argument)
        ]
        inner = None
        for within in _texts(stated.arguments.get("within", "")):
            inner = _element(self.attribute(of, within, node.lineno))
        for name in named:
            first = name.partition(".")[0]
            is_outer = inner is None or first in typing.get_type_hints(of) or hasattr(of, first)
            self.path(of if is_outer else inner, name, node.lineno)

    def type_of(self, node, scope):
        """The type of an expression; None where that is not known."""
        quiet = _Checker()
        match node:
            case nodes.Name():
                return scope.get(node.name)
            case nodes.Getattr():
                return quiet.attribute(self.type_of(node.node, scope), node.attr, 0)
            case nodes.Getitem(arg=nodes.Slice()):
                return self.type_of(node.node, scope)
            case nodes.Getitem():
                return _item(self.type_of(node.node, scope), node.arg)
            case nodes.Filter() if node.node is not None and node.name in _KEEPING:
                return self.type_of(node.node, scope)
            case nodes.Filter() if node.node is not None and node.name in _PICKING:
                return _element(self.type_of(node.node, scope))
            case nodes.Filter(name="map") if node.node is not None:
                names = [k.value.value for k in node.kwargs if k.key == "attribute"]
                of = _element(self.type_of(node.node, scope))
                return list[quiet.path(of, names[0], 0) or object] if names else None
            case nodes.Add():
                return self.type_of(node.left, scope) or self.type_of(node.right, scope)
            case nodes.CondExpr():
                return self.type_of(node.expr1, scope)
            case nodes.Call(node=nodes.Getattr(attr="items" | "values" as name)):
                inner = typing.get_args(_plain(self.type_of(node.node.node, scope)))
                if len(inner) == 2:
                    return list[tuple[inner]] if name == "items" else list[inner[1]]
        return None


def _constants(node):
    """Texts in an expression that is put together of some, or chosen among some."""
    if isinstance(node, nodes.CondExpr):
        return [t for part in (node.expr1, node.expr2) for t in _constants(part)]
    if isinstance(node, nodes.Const):
        return [node.value]
    return [t for part in node.iter_child_nodes() for t in _constants(part)]


def _texts(argument):
    """Texts that are an argument, stated in a template or by default, one or several or keys."""
    if isinstance(argument, nodes.Dict):
        argument = [pair.key for pair in argument.items]
    elif isinstance(argument, nodes.Tuple | nodes.List):
        argument = argument.items
    found = argument if isinstance(argument, list) else [argument]
    values = [one.value if isinstance(one, nodes.Const) else one for one in found]
    return [value for value in values if isinstance(value, str) and value]


def _is_record(of):
    is_named = isinstance(of, type) and issubclass(of, tuple) and hasattr(of, "_fields")
    return isinstance(of, type) and (dataclasses.is_dataclass(of) or is_named)


def _plain(of):
    """A type without None."""
    if typing.get_origin(of) in (typing.Union, types.UnionType):
        inner = [one for one in typing.get_args(of) if one is not types.NoneType]
        return inner[0] if len(inner) == 1 else None
    return of


def _element(of):
    """Type of the elements of what is gone through."""
    of = _plain(of)
    inner = typing.get_args(of)
    if typing.get_origin(of) in (Sequence, Iterable, list, Mapping, dict):
        return inner[0]
    if typing.get_origin(of) is tuple:
        return inner[0] if inner[1:] == (...,) or len(set(inner)) == 1 else None
    return None


def _item(of, at):
    of = _plain(of)
    inner = typing.get_args(of)
    if typing.get_origin(of) in (Mapping, dict):
        return inner[1]
    if typing.get_origin(of) is tuple and ... not in inner:
        return inner[at.value] if isinstance(at, nodes.Const) else None
    return _element(of)
