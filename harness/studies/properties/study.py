"""Properties that must hold of every method, tested on random layouts."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.properties.outcomes import Found


class Properties(Study["Found"]):
    """Property tests; the command fails where one is violated."""

    answers = "Does every method satisfy the physical laws that it must?"
    about = "property tests of methods and engines, on layouts drawn at random"
    workers = 0

    methods: tuple[str, ...] = methods_option(
        "only this method, for example ps3@mujoco; may be repeated "
        "(default: static methods, the label's way and the tuned preset on all engines that are "
        "compared here, learned methods and cascades)"
    )
    limit: int | None = option(
        None, "cases a property and method; a tenth of that for loads on the road (default: 1000)",
        least=1, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Missing pairs of properties and methods are tested."""
        from steadyload.properties import PropertyError

        if importlib.util.find_spec("hypothesis") is None:
            raise PropertyError(
                "property tests need hypothesis: pip install 'steadyload[properties]'"
            )
        from steadyload.studies.properties.testing import EXAMPLES, run_properties

        return run_properties(lab, self.methods, self.limit or EXAMPLES)

    def beside(self, found: Found, folder: Path) -> None:
        """Counterexamples, as layout files."""
        from steadyload.studies.properties.testing import write_counterexamples

        write_counterexamples(found, folder)

    def remarks(self, found: Found) -> Iterator[str]:
        """Cases that methods refused, and violations that are not declared as findings."""
        for method in found.methods:
            if method.refused.cases:
                tried = f"{method.refused.cases} of {method.refused.of} cases"
                yield f"{method.method.spec}: not asked on {tried}, which lie outside its range"
        for row in found.violations:
            why = row.smallest.found if row.smallest else row.why
            yield f"{row.property}, {row.method.spec}: {why}"

    def status(self, found: Found) -> int:
        """1 where a property is violated."""
        return 1 if found.violations else 0
