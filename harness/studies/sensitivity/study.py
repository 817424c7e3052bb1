"""Which conclusions hold whatever the rule by which a loading fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option, set_option

if TYPE_CHECKING:
    from steadyload.studies.sensitivity.ranking import Rankings


class Sensitivity(Study["Rankings"]):
    """Accuracy and rank of methods by the rule that labels are made by."""

    question = "Which conclusions survive another time, threshold or point that is measured?"
    about = "accuracy and rank of every method over the rule by which a loading fails"
    workers = 0
    pages = (PublishedPage("sensitivity", "--directory lists --limit 100"),)

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: the paper's methods, and the best of ours)"
    )
    limit: int = option(50, "cases a scenario, those of the first ranks (default: 50)", least=2)
    directory: str = set_option()

    def run(self, lab: Lab) -> Rankings:
        """Accuracy of methods by every rule, with their own parameters and with the rule's."""
        from steadyload.studies.sensitivity.ranking import ranked

        return ranked(lab, self.methods, self.limit, self.directory)
