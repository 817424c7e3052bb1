"""The paper's experiment, its data set and split rebuilt, compared with stricter splits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.replication.comparing import Found

QUICK_EPOCHS = 10


class Replication(Study["Found"]):
    """Which files, splits and methods, and how long networks are trained."""

    question = "What do the paper's accuracies measure, and how much of them is twins?"
    about = "the paper's experiment as it was run, and on splits without twins"
    workers = 0

    quick: bool = option(
        False, "every third file, labels of the package, networks of 10 epochs: some minutes"
    )
    budget: float = option(
        6.0, "hours of CPU time of all trainings (default: 6)", unit="h", least=0.001
    )
    epochs: int = option(700, "most epochs of a training (default: 700)", least=1)
    seeds: int = option(3, "trainings of LSTM_1 a fold (default: 3)", least=1)
    seed: int = option(0, "of the splits (default: 0)", least=0)
    weights: str = option(
        "paper", "of items: proportional to the volume, or as in the authors' code",
        choices="steadyload.layouts.packing.packing:WeightRule",
    )  # fmt: skip
    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: rules, readings of the paper's simulations, ours)"
    )
    only_labels: bool = option(False, "make the labels that are missing, and end")

    @property
    def most_epochs(self) -> int:
        """Most epochs of a training; a quick run has few."""
        return min(self.epochs, QUICK_EPOCHS) if self.quick else self.epochs

    def run(self, lab: Lab) -> Found:
        """Accuracies of what learns and what does not; of labels alone how many there are."""
        from steadyload.labelling.paper_labels import label_files, shipped_labels
        from steadyload.layouts.benchmark.paper_files import FileOptions, make_files
        from steadyload.layouts.packing.packing import WeightRule
        from steadyload.learners import require_training
        from steadyload.studies.replication.comparing import Found, replicate

        if not self.only_labels:
            require_training()
        options = FileOptions(weights=WeightRule(self.weights))
        files = make_files(options, lambda *of: lab.progress("packing", *of))
        if self.quick and not self.only_labels:
            files, labels = files.quick(), shipped_labels()
        else:
            labelling = label_files(
                files, lab.work, workers=lab.workers,
                progress=lambda *of: lab.progress("labelling", *of),
            )  # fmt: skip
            labels = dict(labelling.labels)
        if self.only_labels:
            return Found(labelling=labelling)
        results = replicate(
            lab,
            files,
            labels,
            seed=self.seed,
            epochs=self.most_epochs,
            budget=3600.0 * self.budget,
            seeds=1 if self.quick else self.seeds,
            ensemble=not self.quick,
            methods=self.methods,
        )
        return Found(results)
