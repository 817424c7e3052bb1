"""All commands in groups: words, import path, and summary.

A command is a frozen dataclass of options (see :mod:`steadyload.config`) with a method
``run``, which returns an exit status, None for 0. Nothing is imported until a command is run. A
study needs no line here: :mod:`steadyload.studies.registry` has it. A study whose command does more
than run it and write its page has a line that replaces the default.
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from steadyload.plugins import PluginError
from steadyload.studies.registry import studies, study


class Group(StrEnum):
    """Groups of commands, in the order of the help."""

    USE = "Use"
    COMPARE = "Compare"
    BUILD = "Build"
    REMAKE = "Remake"


@dataclass(frozen=True)
class Command:
    """A command.

    Attributes:
        words: one, or a topic and an action.
        target: ``"module:Class"``; empty for that of the study.
        about: summary for the help.
        group: the group of the help in which it is listed.
        study: name of the study whose page it writes, if any.
    """

    words: str
    target: str
    about: str
    group: Group
    study: str = ""

    def load(self) -> type[Any]:
        """Its class."""
        if not self.target:
            from steadyload.cli.studies import study_command

            return study_command(study(self.study))
        module, _, name = self.target.partition(":")
        return getattr(importlib.import_module(f"steadyload.cli.{module}"), name)


_OWN: Mapping[Group, tuple[tuple[str, str, str], ...]] = {
    Group.USE: (
        ("check", "check:Check", "do planned pallets stand while they are loaded?"),
        ("repair", "repair:Repair", "find the nearest plans that stand, and write them"),
        ("transport", "transport:Transport",
         "what accelerations do loaded pallets hold on the road?"),
        ("demo", "demo:Demo", "check a dozen shipped pallets, and open their page"),
        ("score", "score:Score", "score layout files with one or more methods"),
        ("view", "view:View", "write a page that plays a loading step by step"),
        ("convert", "convert:Convert", "convert layout files between formats"),
        ("recommend", "recommend:Recommend",
         "name the method to use for a time a layout, or for an accuracy"),
        ("methods", "listings:Methods",
         "list methods and presets, or explain one, NAME or NAME@ENGINE"),
        ("engines", "listings:Engines", "which engine honours which setting"),
        ("warm-up", "warm_up:WarmUp",
         "compile the reference simulator now, which its first use would wait for, a minute, once"),
    ),
    Group.COMPARE: (
        ("study run", "study:Run", "judge the layouts of a study file of your own, or go on"),
        ("reality field", "reality:Field",
         "compare methods with tests of real stacks: placed, tilted, accelerated"),
    ),
    Group.BUILD: (
        ("tune", "tune:Tune",
         "search the parameters of a simulation on an engine, against labels"),
        ("train", "train:Train", "train a learned method (lstm_1, lstm_e) on labelled layouts"),
        ("generate", "train:Generate",
         "pack and label fresh item lists: a larger set to train on"),
        ("cascade fit", "cascade:Fit",
         "find the thresholds of each stage, at the least cost within an error budget"),
        ("benchmark info", "benchmark:Info", "count layouts, labels, splits and verdicts"),
        ("benchmark export", "benchmark:Export",
         "write cases as a layout file, labels beside it"),
        ("benchmark import", "benchmark:Import",
         "bring the authors' published set into our form"),
        ("benchmark build", "benchmark:Build",
         "pack the layouts of a new set, not labelled yet"),
        ("benchmark build-real", "benchmark:BuildReal",
         "a set of real size: customers' pallets and plans of packers, not labelled yet"),
        ("benchmark extend-real", "benchmark:ExtendReal",
         "add large layouts of further item lists to a set of real size, not labelled yet"),
        ("benchmark label", "benchmark_labels:Label",
         "label a set, split it, judge it by further methods; goes on where it was interrupted"),
        ("benchmark judge", "benchmark_labels:Further",
         "judge cases of a labelled set by further methods; goes on where it was interrupted"),
        ("benchmark screen", "benchmark_labels:Screen",
         "label a set of large layouts for both questions; goes on where it was interrupted"),
    ),
    Group.REMAKE: (
        ("pages list", "pages:List", "name published pages, and the command of each"),
        ("pages remake", "pages:Remake",
         "remake published pages from their rows; --judge judges what is missing"),
        ("pages keep", "pages:Keep", "pack the rows that published pages are made of"),
        ("pages index", "pages:Index", "write the index of published pages"),
    ),
}  # fmt: skip
"""Commands that do not belong to a study: words, target and summary; see :class:`Command`."""

_OF_STUDIES = {"report": "study:Report"}
"""Study -> its command, where that does more than run it and write its page."""

TOPICS: Mapping[str, tuple[str, Group]] = {
    "study": (
        "a study of your own, or one of the package: what methods and engines get right, and cost",
        Group.COMPARE,
    ),
    "reality": (
        "methods and engines compared with what was measured of real loads and bodies; with flags "
        "alone it is study reality",
        Group.COMPARE,
    ),
    "cascade": ("fit the thresholds of cascades", Group.BUILD),
    "benchmark": ("the labelled set: look, export, import", Group.BUILD),
    "pages": ("list, remake and index the published pages", Group.REMAKE),
}
"""First word of commands of two words -> summary, and group of the help."""

OF_TOPICS: Mapping[str, str] = {"reality": "study reality"}
"""First word of commands of two words -> the command that flags right after it belong to."""


def commands() -> dict[str, Command]:
    """All commands by their words; studies are imported for their names and summaries.

    A faulty study of another distribution has no command; a warning says so.
    """
    found = {own[0]: Command(*own, group) for group, listed in _OWN.items() for own in listed}
    for name in studies():
        try:
            one = study(name)
        except PluginError as error:
            logging.getLogger("steadyload").warning("%s", error)
            continue
        words = one.command_words
        if words not in found:
            target = _OF_STUDIES.get(name, "")
            found[words] = Command(words, target, one.about, Group.COMPARE, name)
    return found
