"""Networks that are trained and tested once: the same in processes, and never a second time."""

import io
import shutil

import numpy as np
import pytest

pytest.importorskip("torch")

import torch

from steadyload.atomic import CHECKSUM_DIGITS
from steadyload.learners.features import FeatureKind
from steadyload.learners.network import LstmNetwork
from steadyload.learners.options import options_from
from steadyload.learners.sequences import load_sequences
from steadyload.learners.tested import NetworkTraining, train_and_test
from steadyload.runs.store import CHECKPOINTS


@pytest.fixture(scope="module")
def sequences():
    every = load_sequences(FeatureKind.PLAIN, limit=10)
    return [every.chosen(np.arange(len(every)) % 3 == part) for part in range(3)]


def options_of(seed):
    own = {"features": "plain", "hidden": 8, "epochs": 1, "batch": 8, "seed": seed}
    return options_from(own, where="test")


@pytest.fixture
def train(sequences):
    def train(work, seeds=(0,), workers=0):
        def trainings():
            for seed in seeds:
                folder = work / CHECKPOINTS
                yield NetworkTraining("one", options_of(seed), *sequences, folder, 60.0)

        return list(train_and_test(trainings, work, workers=workers))

    return train


def test_processes_train_what_one_process_does(train, tmp_path):
    here, beside = (train(tmp_path / str(n), (0, 1), n) for n in (0, 2))
    for one, other in zip(here, beside, strict=True):
        assert (one.probabilities == other.probabilities).all()
    assert (here[0].probabilities != here[1].probabilities).any()


def test_what_a_network_says_is_what_its_weights_say(train, tmp_path, sequences):
    """Compared with torch, of the checkpoint that the training left."""
    [tested] = train(tmp_path)
    (checkpoint,) = (tmp_path / CHECKPOINTS).glob("one-plain-8-*/checkpoint.pt")
    stored = torch.load(io.BytesIO(checkpoint.read_bytes()[CHECKSUM_DIGITS:]), weights_only=True)
    asked, options = sequences[2], options_of(0)
    network = LstmNetwork(asked.rows.shape[1], options.hidden, options.layers)
    network.load_state_dict(stored["best"])
    with torch.inference_mode():
        told = torch.sigmoid(network(torch.from_numpy(asked.padded()))).numpy()
    within = np.arange(told.shape[1]) < asked.counts[:, None]
    assert tested.probabilities[within] == pytest.approx(told[within], abs=1e-5)
    assert not tested.probabilities[~within].any()


def test_without_checkpoints_nothing_is_trained_again(train, tmp_path):
    [before] = train(tmp_path)
    shutil.rmtree(tmp_path / CHECKPOINTS)
    [after] = train(tmp_path)
    assert after[:-1] == before[:-1]
    assert (after.probabilities == before.probabilities).all()
    assert not (tmp_path / CHECKPOINTS).exists()
