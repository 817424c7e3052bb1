"""The paper's experiment, its data set and split rebuilt, compared with stricter splits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.replication.comparing import Results

FEWEST = 3000
"""Files of which Table 2's test and validation files can be drawn."""


class Replication(Study["Results"]):
    """All files on all splits; or few files, and networks that are hardly trained."""

    answers = "What do the paper's accuracies measure, and how much of them is twins?"
    about = "the paper's experiment as it was run, and on splits without twins"
    workers = 0

    limit: int | None = option(
        None, "only so many files, evenly drawn; LSTM_1 alone, of 10 epochs: some minutes "
        "(default: all)", least=FEWEST, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Results:
        """Accuracies of what learns and what does not; labels that are missing are made first."""
        from steadyload.labelling.building.paper_files import FileOptions, make_files
        from steadyload.labelling.paper_labels import label_files, shipped_labels
        from steadyload.learners import require_training
        from steadyload.studies.replication.comparing import replicate
        from steadyload.studies.replication.methods import FULL, QUICK

        require_training()
        files = make_files(FileOptions(), lambda *of: lab.progress("packing", *of))
        if self.limit is not None:
            return replicate(lab, files.some(self.limit), shipped_labels(), QUICK)
        labels = label_files(
            files, lab.work, workers=lab.workers,
            progress=lambda *of: lab.progress("labelling", *of),
        )  # fmt: skip
        return replicate(lab, files, labels, FULL)
