"""Configuration of the study of the paper's experiment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.config import methods_option, option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import Study

QUICK_EPOCHS = 10


@dataclass(frozen=True)
class ReplicationConfig:
    """Which files, splits and methods, and how long networks are trained."""

    quick: bool = option(
        False, "every third file, labels of the package, networks of 10 epochs: some minutes"
    )
    budget: float = option(
        6.0,
        "hours of CPU time of all trainings (default: 6)",
        unit="h",
        least=0.001,
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


class ReplicationStudy(Study[ReplicationConfig, Any]):
    """The paper's experiment, its data set and split rebuilt, beside stricter splits."""

    name = "replication"
    question = "What do the paper's accuracies measure, and how much of them is twins?"
    about = "the paper's experiment as it was run, and on splits without twins"
    Config = ReplicationConfig
    workers = 0

    def run(
        self,
        config: ReplicationConfig,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The summary of what was judged and trained; of labels alone how many there are."""
        from steadyload.labelling.paper_labels import label_files
        from steadyload.layouts.benchmark.paper_files import FileOptions, make_files
        from steadyload.layouts.packing.packing import WeightRule
        from steadyload.learners import require_training

        files = FileOptions(weights=WeightRule(config.weights))
        if config.only_labels:
            made = make_files(files, lambda *of: progress("packing", *of))
            return label_files(
                made, work, workers=workers, progress=lambda *of: progress("labelling", *of)
            )
        require_training()
        from steadyload.studies.replication.study import ReplicationOptions, replicate
        from steadyload.studies.replication.summary import summarise

        asked = ReplicationOptions(
            quick=config.quick,
            files=files,
            seed=config.seed,
            epochs=min(config.epochs, QUICK_EPOCHS) if config.quick else config.epochs,
            budget=3600.0 * config.budget,
            seeds=1 if config.quick else config.seeds,
            ensemble=not config.quick,
            methods=config.methods,
        )
        return summarise(replicate(asked, work, workers=workers, progress=progress))

    def page(self, result: Any) -> Any:
        """The page of accuracies by split beside the paper's."""
        from steadyload.studies.replication.page import replication_page

        return replication_page(result)


STUDY = ReplicationStudy()
