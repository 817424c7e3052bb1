"""Configuration of the study of closed forms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import Study


@dataclass(frozen=True)
class ClosedFormsConfig:
    """Which engines are compared with formulas."""

    engines: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--engine",), metavar="NAME"
    )


class ClosedForms(Study[ClosedFormsConfig, Any]):
    """Single bodies and small stacks whose motion follows from a formula."""

    name = "closed_forms"
    question = "How far is every engine from mechanics whose answer is known?"
    about = "compare engines with formulas: tipping, sliding, spinning, stacks"
    command = "verify closed-forms"
    Config = ClosedFormsConfig

    def run(
        self,
        config: ClosedFormsConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """Tests, the engines' results, and their provenance."""
        from steadyload.properties.closed_form_tests import closed_form_tests
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.closed_forms.study import closed_forms

        made_with = provenance_lines()
        results = closed_forms(work, config.engines or None, workers=workers, progress=progress)
        return closed_form_tests(), results, made_with

    def page(self, result: Any) -> Any:
        """The page of errors, test by test."""
        from steadyload.studies.closed_forms.page import closed_forms_page

        return closed_forms_page(*result)


STUDY = ClosedForms()
