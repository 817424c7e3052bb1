"""Configuration of the study of loading sessions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import Study

PARTS = ("cost", "gain")


@dataclass(frozen=True)
class SessionConfig:
    """Which parts, by which methods, and on how much."""

    parts: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--part",), choices=PARTS
    )
    methods: tuple[str, ...] = methods_option(
        "measure only this; may be repeated (default: those of the published page)"
    )
    judge: str | None = option(
        None, "judges what was packed (default: label@reference)", metavar="SPEC"
    )
    lists: int = option(5, "item lists of each class that are packed (default: 5)", least=1)
    most_items: int = option(
        200, "items that are loaded where cost is measured (default: 200)", least=40, metavar="J"
    )


class SessionStudy(Study[SessionConfig, Any]):
    """Cost of sessions, and their gain for packing heuristics."""

    name = "session"
    question = "What does judging while packing cost, and what is gained by it?"
    about = "pack with and without rejecting what is not stable; what a placement costs"
    Config = SessionConfig
    workers = None

    def run(
        self,
        config: SessionConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The costs, scenes and gains, and their provenance."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.session.packing_gains import JUDGE, REJECTING, packing_gains
        from steadyload.studies.session.study import COSTED, SCENES, session_curves

        parts = config.parts or PARTS
        curves, made_with = (
            session_curves(
                work, config.methods or COSTED, count=config.most_items, progress=progress
            )
            if "cost" in parts
            else ([], provenance_lines())
        )
        tasks = (
            packing_gains(
                work,
                config.methods or REJECTING,
                judge=config.judge or JUDGE,
                instances=config.lists,
                progress=progress,
            )
            if "gain" in parts
            else []
        )
        return curves, {scene.name: scene.about for scene in SCENES}, tasks, made_with

    def page(self, result: Any) -> Any:
        """The page of the cost of placements and of the gain for packing."""
        from steadyload.studies.session.page import session_page

        return session_page(*result)


STUDY = SessionStudy()
