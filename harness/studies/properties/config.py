"""Configuration of the study of properties."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.progress import NamedProgress as Progress
from steadyload.progress import silent
from steadyload.studies.study import PublishedPage, Study

PROFILES = ("quick", "ci", "deep")


@dataclass(frozen=True)
class PropertiesConfig:
    """Which methods, which properties, and on how many cases."""

    engines: tuple[str, ...] = option(
        (), "only the label's way on this engine; may be repeated", names=("--engine",),
        metavar="NAME",
    )  # fmt: skip
    methods: tuple[str, ...] = methods_option(
        "only this method, for example ps3@mujoco; may be repeated "
        "(default: static methods, the label's way and the tuned preset on every engine that needs "
        "no extra, learned methods and a cascade)"
    )
    properties: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--property",), metavar="NAME"
    )
    profile: str = option(
        "quick", "cases a property and method: quick 20, ci 100, deep 1000 (default: quick)",
        choices=PROFILES,
    )  # fmt: skip
    examples: int | None = option(None, "so many cases, whatever the profile", least=1)
    seed: int = option(0, "of the cases (default: 0)", least=0)


class Properties(Study[PropertiesConfig, Any]):
    """Properties that must hold of a method, tested on random layouts."""

    name = "properties"
    question = "Does what must hold of every judge hold of each?"
    about = "property tests of methods and engines, on layouts drawn at random"
    Config = PropertiesConfig
    workers = 0
    published = (PublishedPage("properties", "--profile deep --seed 1 --work runs/properties"),)

    def run(
        self, config: PropertiesConfig, work: Path, *, workers: int = 1, progress: Progress = silent
    ) -> Any:
        """The table and its provenance; counterexamples are written to ``work``."""
        return self.run_beside(config, work, work, workers=workers, progress=progress)

    def run_beside(
        self,
        config: PropertiesConfig,
        work: Path,
        output: Path,
        *,
        workers: int,
        progress: Progress,
    ) -> Any:
        """The result of :meth:`run`, with counterexamples beside the page in ``output``."""
        from steadyload.properties import PropertyError

        if importlib.util.find_spec("hypothesis") is None:
            raise PropertyError(
                "property tests need hypothesis: pip install 'steadyload[properties]'"
            )
        from steadyload.properties import search
        from steadyload.properties.registry import chosen
        from steadyload.studies.properties.study import (
            PropertyStudy,
            made_with,
            methods_on,
            run_properties,
        )

        methods = list(config.methods)
        if config.engines or not methods:
            methods += methods_on(config.engines or None)
        study = PropertyStudy(
            methods=tuple(dict.fromkeys(methods)),
            properties=tuple(chosen(config.properties or None)),
            examples=config.examples or search.PROFILES[config.profile],
            seed=config.seed,
        )
        manifest = made_with(study)
        table = run_properties(
            study, work, output=output, workers=workers,
            progress=lambda *of: progress("asking", *of),
        )  # fmt: skip
        return table, manifest

    def page(self, result: Any) -> Any:
        """The page of violations, with their smallest layouts, and of properties that hold."""
        from steadyload.studies.properties.page import properties_page

        return properties_page(*result)


STUDY = Properties()
