"""Rules of the road: what acceleration a load must hold, by direction, and what holding means."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from steadyload.errors import nearest
from steadyload.escaping import shown
from steadyload.reading import toml_of
from steadyload.transport.errors import TransportError
from steadyload.transport.history import STEEPEST, History, trapezoid

_SIDES = {"forwards": (0.0,), "sideways": (90.0, 270.0), "backwards": (180.0,)}
"""Directions of the force on the load [degrees] by side: its width is its length on the road."""

_LONGEST_TEXT = 300


@dataclass(frozen=True)
class Rule:
    """An acceleration by direction, and the movement that a box may make under it.

    Attributes:
        name, title, source: for people.
        levels: acceleration [g] by side, ``forwards``, ``sideways``, ``backwards``.
        rise, hold, rest: [s] until the level is reached, of the level, of watching after it.
        displacement: of a box's centre relative to the deck [cm]; 0 for a share of the height.
        displacement_share: of the height of the load, where there is no displacement.
        rotation: of a box [degrees].
        tilted: the deck is tilted, see :class:`steadyload.transport.history.History`.

    Raises:
        TransportError: a text that is not printable, no level, a side that is none, a number that
            is none or out of range, or not just one of the two limits of displacement.
    """

    name: str
    title: str
    source: str
    levels: Mapping[str, float]
    rise: float
    hold: float
    rest: float
    rotation: float
    displacement: float = 0.0
    displacement_share: float = 0.0
    tilted: bool = False

    def __post_init__(self) -> None:
        for name in ("name", "title", "source"):
            text = getattr(self, name)
            if not (isinstance(text, str) and text.isprintable() and len(text) <= _LONGEST_TEXT):
                raise TransportError(
                    f"{name} of a rule is {shown(text)}; allowed: a printable text of up to "
                    f"{_LONGEST_TEXT} characters"
                )
        if not isinstance(self.levels, Mapping) or not self.levels:
            raise TransportError(
                f"rule {self.name}: levels is {shown(self.levels)}; allowed: accelerations [g] by "
                f"side, such as levels = {{ forwards = 0.5 }}, of {', '.join(_SIDES)}"
            )
        for side, level in self.levels.items():
            if side not in _SIDES:
                raise TransportError(
                    f"rule {self.name}: side {shown(side)}; {nearest(side, _SIDES)}"
                )
            self._check(f"level {side}", level, 0.0, STEEPEST)
        for name in ("rise", "hold", "rest", "displacement", "displacement_share"):
            self._check(name, getattr(self, name), 0.0, 1000.0)
        self._check("rotation", self.rotation, 0.1, 1000.0)
        if not isinstance(self.tilted, bool):
            raise TransportError(
                f"rule {self.name}: tilted is {shown(self.tilted)}; allowed: true, false"
            )
        if (self.displacement > 0.0) == (self.displacement_share > 0.0):
            raise TransportError(
                f"rule {self.name}: allowed: displacement or displacement_share, above 0, just one"
            )
        for level in self.levels.values():
            self.history(level)  # refuses what no history can be

    def _check(self, name: str, value: Any, least: float, most: float) -> None:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and least <= value <= most):
            raise TransportError(
                f"rule {self.name}: {name} is {shown(value)}; allowed: {least:g} to {most:g}"
            )

    def history(self, level: float) -> History:
        """The rule's history at a level [g]."""
        return trapezoid(level, self.rise, self.hold, tilted=self.tilted)

    def directions(self) -> dict[float, float]:
        """The level [g] by direction [degrees], in the order of directions."""
        found = {d: g for side, g in self.levels.items() for d in _SIDES[side]}
        return dict(sorted(found.items()))

    def level(self, direction_deg: float) -> float:
        """The level [g] in one of the rule's directions [degrees].

        Raises:
            TransportError: it is none of them.
        """
        levels = self.directions()
        if direction_deg not in levels:
            allowed = ", ".join(f"{one:g}" for one in levels)
            raise TransportError(
                f"rule {self.name}: direction {shown(direction_deg)}; allowed: {allowed} [degrees]"
            )
        return levels[direction_deg]

    def largest_displacement(self, height: float) -> float:
        """Largest movement of a box [cm] in a load of a height [cm]."""
        return self.displacement or self.displacement_share * height


@cache
def rules() -> dict[str, Rule]:
    """The rules that come with the package, by name."""
    text = (
        resources.files("steadyload.transport").joinpath("rules.toml").read_text(encoding="utf-8")
    )
    return _rules(tomllib.loads(text), "rules.toml")


def rule_named(name: str) -> Rule:
    """A rule by its name, or the only one of a TOML file.

    Raises:
        TransportError: there is none.
        TooLargeError: the file has too many bytes.
    """
    if name in rules():
        return rules()[name]
    path = Path(name)
    if path.suffix != ".toml":
        raise TransportError(
            f"rule {shown(name)}; {nearest(name, rules())}, or a TOML file of one rule"
        )
    try:
        content = toml_of(path, TransportError)
    except OSError as error:
        raise TransportError(f"{name}: cannot be read ({error.strerror})") from None
    found = _rules(content, name)
    if len(found) != 1:
        raise TransportError(f"{name}: holds {len(found)} rules; allowed: one table [NAME]")
    return next(iter(found.values()))


def _rules(content: Mapping[str, Any], file: str) -> dict[str, Rule]:
    known = {f.name for f in fields(Rule)} - {"name"}
    found = {}
    for name, given in content.items():
        if not isinstance(given, dict):
            raise TransportError(f"{file}: {shown(name)} is no table; allowed: one rule a table")
        for key in given:
            if key not in known:
                raise TransportError(
                    f"{file}: {shown(name)}: unknown key {shown(key)}; {nearest(key, known)}"
                )
        try:
            found[name] = Rule(**{"name": name, "title": name, "source": "", **given})
        except TypeError as error:
            raise TransportError(f"{file}: {shown(name)}: {error}") from None
    return found
