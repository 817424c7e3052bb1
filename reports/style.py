"""Colour and marker of every method, fixed here once: the same on every page and in every figure.

The colour tells the family (rule or tuning), the marker tells the engine; it is hollow where a
method has parameters of its own.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

_FAMILY_COLOURS = {
    "fbs": "#7f7f7f",
    "pbs": "#8c6d31",
    "pbs0.9": "#5e4a21",
    "pbs0.7": "#8c6d31",
    "pbs0.5": "#c4a052",
    "sme": "#2ca02c",
    "equilibrium": "#98df8a",
    "ps3": "#1f77b4",
    "ps5": "#17becf",
    "ps3-literal": "#6baed6",
    "ps5-literal": "#9edae5",
    "ps_opt-paper": "#d62728",
    "ps_opt": "#e377c2",
    "simulation": "#ff7f0e",
    "lstm_1": "#bcbd22",
    "lstm_e": "#9467bd",
    "cascade": "#000000",
    "label": "#00695c",
}
_ENGINE_MARKERS = {
    None: "o",
    "bullet": "s",
    "mujoco": "^",
    "dart": "D",
    "chipmunk": "v",
    "reference": "*",
}
_ENGINE_COLOURS = {
    None: "#4d4d4d",
    "bullet": "#1f77b4",
    "mujoco": "#d62728",
    "dart": "#2ca02c",
    "chipmunk": "#9467bd",
    "reference": "#000000",
}
_SPARE_COLOURS = ("#e6550d", "#637939", "#843c39", "#17becf", "#3182bd", "#7b4173")
_SPARE_MARKERS = ("P", "X", "h", "<", ">", "p")


class Identified(Protocol):
    """Whatever has the names that fix its colour and marker, such as a method's key."""

    @property
    def title(self) -> str:
        """Name in tables and legends."""

    @property
    def spec(self) -> str:
        """Its identity, with its parameters."""

    @property
    def family(self) -> str:
        """Fixes the colour."""

    @property
    def engine(self) -> str | None:
        """Fixes the marker."""


def colour(method: Identified) -> str:
    """The method's colour; a family without one gets a spare colour by its name."""
    return _FAMILY_COLOURS.get(method.family) or _spare(method.family, _SPARE_COLOURS)


def marker(method: Identified) -> str:
    """The method's marker, which is its engine's."""
    return engine_marker(method.engine)


def engine_marker(engine: str | None) -> str:
    """The marker of an engine, or of none; one without a marker gets a spare one by its name."""
    return _ENGINE_MARKERS.get(engine) or _spare(str(engine), _SPARE_MARKERS)


def face(method: Identified) -> str:
    """The inside of the method's marker: its colour, white where its spec names parameters."""
    return "white" if ":" in method.spec else colour(method)


def engine_colour(engine: str | None) -> str:
    """The colour of an engine, or of none, where a figure compares engines and not methods."""
    return _ENGINE_COLOURS.get(engine) or _spare(str(engine), _SPARE_COLOURS)


DASHES = ("-", "--", ":", "-.")
"""Dashes of lines in turn."""

PLACES = tuple(
    zip(
        ("#08519c", "#e6550d", "#2ca02c", "#9467bd", "#7f7f7f", "#8c6d31"),
        ("o", "s", "^", "D", "v", "P"),
        strict=True,
    )
)
"""Colours and markers in turn, of what has none of its own."""


class Look(NamedTuple):
    """Colour and marker of a line or of a point, and the colour inside the marker."""

    colour: str
    marker: str
    face: str


def _of_engine(engine: str | None, _: int) -> Look:
    return Look(engine_colour(engine), engine_marker(engine), engine_colour(engine))


def _in_turn(_: object, place: int) -> Look:
    shade, sign = PLACES[place % len(PLACES)]
    return Look(shade, sign, shade)


LOOKS: Mapping[str, Callable[[Any, int], Look]] = {
    "method": lambda method, _: Look(colour(method), marker(method), face(method)),
    "engine": _of_engine,
    "place": _in_turn,
}
"""How the look of something follows from what it is, or from its place among others."""


def _spare(name: str, choices: tuple[str, ...]) -> str:
    return choices[zlib.crc32(name.encode()) % len(choices)]
