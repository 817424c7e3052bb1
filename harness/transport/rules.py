"""Rules of the road: what acceleration a load must hold, by direction, and what holding means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from pathlib import Path

from steadyload.config import REQUIRED, bind, check, option
from steadyload.errors import nearest, required
from steadyload.escaping import shown
from steadyload.reading import own_file, toml_of
from steadyload.transport.errors import TransportError
from steadyload.transport.history import STEEPEST, History, trapezoid


class Side(StrEnum):
    """A side of a load on the road."""

    FORWARDS = "forwards"
    SIDEWAYS = "sideways"
    BACKWARDS = "backwards"


_SIDES = {Side.FORWARDS: (0.0,), Side.SIDEWAYS: (90.0, 270.0), Side.BACKWARDS: (180.0,)}
"""Directions of the force on the load [degrees] by side: its width is its length on the road."""

_LONGEST_TEXT = 300


def _printable(text: str) -> str:
    if not (text.isprintable() and len(text) <= _LONGEST_TEXT):
        raise ValueError(
            f"{shown(text)}; allowed: a printable text of up to {_LONGEST_TEXT} characters"
        )
    return text


@dataclass(frozen=True)
class Rule:
    """An acceleration by direction, and the movement that a box may make under it.

    Raises:
        TransportError: a text that is not printable, no level, a side that is none, a number that
            is none or out of range, or not just one of the two limits of displacement.
    """

    name: str = option(REQUIRED, "for people", read=_printable)
    title: str = option(REQUIRED, "for people", read=_printable)
    source: str = option(REQUIRED, "for people", read=_printable)
    levels: Mapping[Side, float] = option(
        REQUIRED, "acceleration by side", unit="g", least=0, most=STEEPEST, fewest=1
    )
    rise: float = option(REQUIRED, "until the level is reached", unit="s", least=0, most=1000)
    hold: float = option(REQUIRED, "of the level", unit="s", least=0, most=1000)
    rest: float = option(REQUIRED, "of watching after it", unit="s", least=0, most=1000)
    rotation: float = option(REQUIRED, "of a box", unit="degrees", least=0.1, most=1000)
    displacement: float = option(
        0.0, "of a box's centre relative to the deck; 0 for a share of the height", unit="cm",
        least=0, most=1000,
    )  # fmt: skip
    displacement_share: float = option(
        0.0, "of the height of the load, where there is no displacement", least=0, most=1000
    )
    tilted: bool = option(False, "the deck is tilted, see History")

    def __post_init__(self) -> None:
        check(self, "rule", TransportError)
        if (self.displacement > 0.0) == (self.displacement_share > 0.0):
            raise TransportError(
                f"displacement is {self.displacement:g}, displacement_share "
                f"{self.displacement_share:g}; allowed: just one of them above 0"
            )
        for level in self.levels.values():
            self.history(level)  # refuses what no history can be

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
    return _rules(own_file("steadyload.transport", "rules.toml"))


def rule_of(rule: str | Rule) -> Rule:
    """The rule that a caller hands over, as itself or by its name or file.

    Raises:
        WrongTypeError: it is neither.
        TransportError: there is none of that name.
    """
    if isinstance(rule, str):
        return rule_named(rule)
    return required("transport", rule, Rule, f"a Rule, a TOML file of one, {', '.join(rules())}")


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
        found = _rules(path)
    except OSError as error:
        raise TransportError(f"{name}: cannot be read ({error.strerror})") from None
    if len(found) != 1:
        raise TransportError(f"{name}: holds {len(found)} rules; allowed: one table [NAME]")
    return next(iter(found.values()))


def _rules(file: Path) -> dict[str, Rule]:
    """The rules of a file by name; a rule without a title has its name for one."""
    return {
        name: bind(Rule, _titled(name, table), f"{file}: {shown(name)}", TransportError, name=name)
        for name, table in toml_of(file, TransportError).items()
    }


def _titled(name: str, table: object) -> object:
    return {"title": name, "source": "", **table} if isinstance(table, Mapping) else table
