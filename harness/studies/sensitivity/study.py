"""Which conclusions hold whatever the rule by which a loading fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.sensitivity.ranking import Found


class Sensitivity(Study["Found"]):
    """Accuracy and rank of methods by the rule that labels are made by."""

    answers = "Which conclusions survive another time, threshold or point that is measured?"
    about = "accuracy and rank of every method over the rule by which a loading fails"
    workers = 0
    verdicts = True

    limit: int | None = option(None, "only the first N cases a scenario (default: 100)", least=2)

    def run(self, lab: Lab) -> Found:
        """Accuracy of methods by every rule, with their own parameters and with the rule's."""
        from steadyload.studies.sensitivity.ranking import compare

        return compare(lab, self.limit)
