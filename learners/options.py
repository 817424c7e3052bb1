"""Options of a training, and the presets of ``presets.toml``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Any

from steadyload import config
from steadyload.engines.quantities import check_ranges, quantity
from steadyload.errors import nearest
from steadyload.learners import LearnerError
from steadyload.learners.features import SYMMETRIES, FeatureKind
from steadyload.learners.inference import HEADS
from steadyload.methods.contract.spec import SpecError, bind
from steadyload.reading import own_file, toml_of


class NetworkKind(StrEnum):
    """Kind of network.

    ``lstm``: LSTM layers and one linear unit, as in the paper. ``attention``: at every step the
    state of the LSTM looks back at the features of the items placed by then (the paper's future
    work), and both decide.
    """

    LSTM = "lstm"
    ATTENTION = "attention"


def allows(network: NetworkKind, hidden: int) -> bool:
    """True if a network can have states of a size: attention shares them among its heads."""
    return network is not NetworkKind.ATTENTION or hidden % HEADS == 0


class Optimizer(StrEnum):
    """Optimiser, of those in Table 4."""

    ADAM = "adam"
    ADAMW = "adamw"


class Schedule(StrEnum):
    """The learning rate over the epochs: as it is, or along half a cosine down to a hundredth."""

    CONSTANT = "constant"
    COSINE = "cosine"


@dataclass(frozen=True)
class TrainingOptions:
    """Options of training one network: everything that its weights depend on but the data.

    Raises:
        LearnerError: a number is out of its range, or the hidden size is none for attention.
    """

    features: FeatureKind = quantity(FeatureKind.SUPPORT, "what the network is told of a step")
    network: NetworkKind = quantity(NetworkKind.LSTM, "which network")
    hidden: int = quantity(128, "size of the states", least=1, most=4096)
    layers: int = quantity(2, "LSTM layers", least=1, most=8)
    dropout: float = quantity(0.0, "between layers", least=0.0, most=0.9)
    optimizer: Optimizer = quantity(Optimizer.ADAM, "which optimiser")
    learning_rate: float = quantity(1e-3, "of the optimiser", least=1e-7, most=1.0)
    weight_decay: float = quantity(0.0, "of the optimiser", least=0.0, most=1.0)
    schedule: Schedule = quantity(Schedule.COSINE, "the learning rate over the epochs")
    epochs: int = quantity(60, "passes over the training data", least=1)
    patience: int = quantity(1000, "epochs without a better one before it ends", least=1)
    batch: int = quantity(128, "layouts a step of the optimiser", least=1)
    symmetries: int = quantity(
        SYMMETRIES, "of the pallet's 8 turns and mirrors, how many are drawn from; 1 is none",
        least=1, most=SYMMETRIES,
    )  # fmt: skip
    least_share: float = quantity(
        0.0, "of the largest set, that every other one comes to in an epoch, by repetition",
        least=0.0, most=1.0,
    )  # fmt: skip
    seed: int = quantity(0, "of weights, order and symmetries", least=0, most=2**32 - 1)

    def __post_init__(self) -> None:
        try:
            check_ranges(self)
        except ValueError as error:
            raise LearnerError(str(error)) from None
        if not allows(self.network, self.hidden):
            raise LearnerError(f"hidden is {self.hidden}; allowed: a multiple of {HEADS} here")


@dataclass(frozen=True, slots=True)
class TrainingPreset:
    """Options under a name, and how long training may take.

    Attributes:
        title: what it is for, in a sentence.
        members: networks, each trained on its own.
        left_out: share of the item lists that every member leaves out of its training; it is
            stopped by them. 0: all are learnt from, and the validation part stops.
        budget: seconds over all members, see :meth:`.Training.run`.
        networks: options of every member by name, which differ from ``options``; empty where all
            members have the same.
    """

    name: str
    title: str
    options: TrainingOptions
    members: int
    left_out: float
    budget: float
    networks: tuple[Mapping[str, Any], ...] = ()


@cache
def training_presets() -> Mapping[str, TrainingPreset]:
    """All presets by name."""
    file = own_file("steadyload.learners", "presets.toml")
    return {
        name: config.bind(TrainingPreset, table, f"{file}: {name}", LearnerError, name=name)
        for name, table in toml_of(file, LearnerError).items()
    }


def training_preset(name: str) -> TrainingPreset:
    """A preset.

    Raises:
        LearnerError: no such preset.
    """
    found = training_presets().get(name)
    if found is None:
        raise LearnerError(f"preset is {name!r}; {nearest(name, training_presets())}")
    return found


def options_from(values: Mapping[str, Any], *, where: str) -> TrainingOptions:
    """Options from texts or plain values.

    Raises:
        LearnerError: an unknown key, or a value that is not allowed.
    """
    try:
        return bind(TrainingOptions, values, where=where)
    except SpecError as error:
        raise LearnerError(str(error)) from None
