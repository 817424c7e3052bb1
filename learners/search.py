"""Bayesian search of Table 4: learning rate, hidden size, optimiser. It can be interrupted.

Every proposal hangs on the search's seed, its number and what came out before. Optuna's journal in
the folder keeps trials; checkpoints beside it keep the epochs of the one that was interrupted.
"""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.atomic import manifest_text, not_a_link, write_atomically
from steadyload.learners import LearnerError
from steadyload.learners.options import Optimizer, TrainingOptions, allows
from steadyload.learners.sequences import HeldOut, Sequences
from steadyload.learners.training import Training
from steadyload.methods.contract.spec import as_plain
from steadyload.progress import Progress, silent
from steadyload.runs.provenance import raised
from steadyload.stored import differing, stored_object

VERSION = 1
"""Of what is proposed: raised when the same search would propose something else."""

LEARNING_RATES = (1e-4, 1e-3)
HIDDEN = (100, 125, 150, 175, 200)
"""The ranges of Table 4; learning rates are drawn on a logarithmic scale. Of the hidden sizes only
those that the network allows are proposed."""

JOURNAL, _IDENTITY = "trials.journal", "search.json"


@dataclass(frozen=True, slots=True)
class TrialResult:
    """One set of hyperparameters and the accuracy that the training stopped with."""

    number: int
    options: TrainingOptions
    accuracy: float


def search_hyperparameters(
    options: TrainingOptions,
    directory: Path,
    data: Sequences,
    stopping: Sequences,
    *,
    held_out: HeldOut | None,
    trials: int,
    budget: float = math.inf,
    seed: int = 0,
    device: str = "cpu",
    progress: Progress = silent,
) -> list[TrialResult]:
    """Search; the folder of an interrupted search is resumed.

    Args:
        options: what is not searched.
        directory: of the search.
        data: see :class:`steadyload.learners.training.Training`, as for the next two.
        stopping: likewise.
        held_out: likewise.
        trials: in all, those of earlier runs too.
        budget: no trial but the first is begun after so many wall seconds of this run.
        seed: of the proposals.
        device: as torch names it.
        progress: called with trials done and trials in all.

    Returns:
        All finished trials, the best first.

    Raises:
        LearnerError: Optuna is missing, or the folder holds another search.
        LeakError: see :class:`steadyload.learners.training.Training`.
    """
    optuna = _optuna()
    directory.mkdir(parents=True, exist_ok=True)
    _claim(
        directory / _IDENTITY,
        {
            "options": as_plain(options),
            "seed": seed,
            "data": data.fingerprint(),
            "stopping": stopping.fingerprint(),
            **raised(VERSION),
        },
    )
    study = _opened(optuna, not_a_link(directory / JOURNAL))
    for trial in study.get_trials(states=(optuna.trial.TrialState.RUNNING,)):
        # Interrupted. The next proposal is the same one, and its checkpoint is there.
        study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
    hidden = [size for size in HIDDEN if allows(options.network, size)]
    begun = time.perf_counter()
    while (done := len(_finished(study))) < trials and (
        not done or time.perf_counter() - begun < budget
    ):
        progress(done, trials)
        study.sampler = optuna.samplers.TPESampler(seed=seed + done, n_startup_trials=5)
        trial = study.ask()
        chosen = dataclasses.replace(
            options,
            learning_rate=trial.suggest_float("learning_rate", *LEARNING_RATES, log=True),
            hidden=trial.suggest_categorical("hidden", hidden),
            optimizer=Optimizer(
                trial.suggest_categorical("optimizer", [str(o) for o in Optimizer])
            ),
        )
        folder = f"{chosen.learning_rate:.6e}-{chosen.hidden}-{chosen.optimizer}"
        training = Training(
            directory / folder, chosen, data, stopping, held_out=held_out, device=device
        )
        trained = training.run()
        study.tell(trial, trained.best.accuracy)
    progress(len(_finished(study)), trials)
    results = [
        TrialResult(
            number,
            dataclasses.replace(
                options,
                learning_rate=trial.params["learning_rate"],
                hidden=trial.params["hidden"],
                optimizer=Optimizer(trial.params["optimizer"]),
            ),
            float(trial.value),
        )
        for number, trial in enumerate(_finished(study))
    ]
    return sorted(results, key=lambda result: -result.accuracy)


def _opened(optuna: Any, journal: Path) -> Any:
    """The study of a journal, which is made when it does not exist."""
    try:
        backend = optuna.storages.journal.JournalFileBackend(str(journal))
        study = optuna.create_study(
            study_name="table 4",
            storage=optuna.storages.JournalStorage(backend),
            direction="maximize",
            load_if_exists=True,
        )
        for trial in _finished(study):
            float(trial.value), trial.params["learning_rate"], Optimizer(trial.params["optimizer"])
    except OSError:
        raise
    except Exception as error:  # Optuna raises what the damage leads to
        raise LearnerError(f"{journal}: is damaged; remove it to start anew") from error
    return study


def _finished(study: Any) -> list[Any]:
    return [trial for trial in study.get_trials(deepcopy=False) if trial.state.name == "COMPLETE"]


def _claim(path: Path, identity: dict[str, Any]) -> None:
    if path.exists():
        found = stored_object(path, "remove it and search again with the options of before")
        differs = differing(found, identity)
        if differs:
            raise LearnerError(
                f"{path}: is of another search ({differs} differ); choose another "
                "folder, or remove it"
            )
    else:
        write_atomically(path, manifest_text(identity))


def _optuna() -> Any:
    try:
        import optuna
        import optuna.storages.journal
    except ModuleNotFoundError as error:
        if error.name != "optuna":
            raise
        raise LearnerError("the search needs Optuna: pip install 'steadyload[learners]'") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna
