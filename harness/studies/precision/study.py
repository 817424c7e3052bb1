"""Verdicts of engines of single and double precision on loads that are moved and scaled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option, set_option

if TYPE_CHECKING:
    from steadyload.studies.precision.comparing import Found


class Precision(Study["Found"]):
    """Which cases, on which engines."""

    question = "What does single precision cost, and what does a contact model?"
    about = "verdicts of single- and double-precision engines on loads that are moved and scaled"
    pages = (PublishedPage("precision", "--directory lists"),)

    directory: str = set_option()
    limit: int = option(100, "only the first N cases a scenario (default: 100)", least=2)
    engines: tuple[str, ...] = option(
        (), "only this engine; may be repeated (default: all of three dimensions and fixed steps "
        "that are installed)", names=("--engine",), metavar="NAME",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Verdicts under every change, and closed forms at several sizes."""
        from steadyload.studies.precision.comparing import compare

        return compare(lab, self.directory, self.limit, self.engines)
