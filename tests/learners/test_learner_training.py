"""Training: it learns, it goes on after a kill to the same bits, and it refuses what cannot be."""

import dataclasses
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import optuna.storages.journal
import pandas as pd
import pytest
import torch

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, write_tables
from steadyload.learners import LeakError, LearnerError
from steadyload.learners.features import FeatureKind
from steadyload.learners.inference import Network
from steadyload.learners.jobs import (
    TrainingJob,
    search_options,
    train_weights,
)
from steadyload.learners.options import (
    NetworkKind,
    Schedule,
    TrainingOptions,
    options_from,
    training_preset,
    training_presets,
)
from steadyload.learners.scoring import accuracies
from steadyload.learners.search import (
    HIDDEN,
    JOURNAL,
    LEARNING_RATES,
    search_hyperparameters,
)
from steadyload.learners.sequences import HeldOut, joined, load_sequences, repeated
from steadyload.learners.training import CHECKPOINT, Training, _rate
from steadyload.learners.weights import load_arrays, load_weights

ROOT = Path(__file__).parents[2]
NOTHING = HeldOut(frozenset(), frozenset())
TINY = TrainingOptions(hidden=8, layers=1, epochs=6, batch=16, learning_rate=1e-2)
DROPPING = dataclasses.replace(TINY, layers=2, dropout=0.3)


@pytest.fixture(autouse=True)
def _one_thread():
    torch.set_num_threads(1)


@pytest.fixture(scope="module")
def data():
    return load_sequences(FeatureKind.SUPPORT, limit=20)


@pytest.fixture(scope="module")
def stopping():
    return load_sequences(FeatureKind.SUPPORT, "validation", limit=10)


@pytest.mark.parametrize("network", NetworkKind)
def test_thirty_layouts_are_learnt_by_heart(tmp_path, network):
    """A network that cannot even do that is wired wrongly. What it is told of items is plain."""
    few = load_sequences(FeatureKind.PLAIN, limit=10)
    assert 0.3 < (few.safe == few.counts).mean() < 0.9
    options = TrainingOptions(
        features=FeatureKind.PLAIN, network=network, hidden=32, epochs=60, batch=8,
        learning_rate=1e-2, symmetries=1,
    )  # fmt: skip
    # What stops it is what it learns from: said with item lists of other names.
    same = dataclasses.replace(few, instances=np.array(["other"] * len(few), dtype=object))
    trained = Training(tmp_path, options, few, same, held_out=NOTHING).run()
    assert trained.best.accuracy >= 0.96
    found = Network(trained.arrays).probabilities_of_many(few.padded())
    assert accuracies(found, few)["all"] == pytest.approx(trained.best.accuracy)
    assert trained.history[-1].loss < 0.1 * trained.history[0].loss


CHILD = """
import sys, time, torch
from pathlib import Path
from steadyload.learners.features import FeatureKind
from steadyload.learners.options import TrainingOptions
from steadyload.learners.sequences import HeldOut, load_sequences
from steadyload.learners.training import Training
torch.set_num_threads(1)
options = TrainingOptions(hidden=8, layers=2, epochs=6, batch=16, learning_rate=1e-2, dropout=0.3)
data = load_sequences(FeatureKind.SUPPORT, limit=20)
stopping = load_sequences(FeatureKind.SUPPORT, "validation", limit=10)
training = Training(Path(sys.argv[1]), options, data, stopping,
                    held_out=HeldOut(frozenset(), frozenset()))
told = lambda epoch: (print(epoch.number, flush=True), time.sleep(epoch.number // 3))
training.run(progress=told)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory, data, stopping):
    """A training that nothing ended early."""
    return Training(tmp_path_factory.mktemp("whole"), DROPPING, data, stopping,
                    held_out=NOTHING).run()  # fmt: skip


def goes_on_to(whole, folder, data, stopping, rounding=1e-4):
    """Assert that a training goes on from where it was to the weights of the whole one.

    On some processors to the last bit; on others PyTorch rounds by where arrays lie in memory.
    """
    seen = []
    again = Training(folder, DROPPING, data, stopping, held_out=NOTHING)
    trained = again.run(progress=lambda epoch: seen.append(epoch.number))
    assert seen[-1] == 6
    assert 3 <= seen[0] <= 5  # not from the start
    losses, accuracy = ([getattr(e, n) for e in whole.history] for n in ("loss", "accuracy"))
    assert [e.loss for e in trained.history] == pytest.approx(losses, rel=rounding, abs=0.0)
    assert [e.accuracy for e in trained.history] == accuracy
    for name, array in whole.arrays.items():
        np.testing.assert_allclose(trained.arrays[name], array, rtol=rounding, atol=rounding)


def test_an_interrupted_training_goes_on_to_the_same_weights(tmp_path, whole, data, stopping):
    def interrupt(epoch):
        if epoch.number == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Training(tmp_path, DROPPING, data, stopping, held_out=NOTHING).run(progress=interrupt)
    goes_on_to(whole, tmp_path, data, stopping)


def test_a_killed_training_goes_on_to_the_same_weights(tmp_path, whole, data, stopping):
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(tmp_path / "killed")],
        stdout=subprocess.PIPE, text=True, cwd=ROOT, env={"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert child.stdout is not None
    for line in child.stdout:
        if line.strip() == "2":
            break
    child.send_signal(signal.SIGKILL)
    child.stdout.close()
    assert child.wait() == -signal.SIGKILL
    goes_on_to(whole, tmp_path / "killed", data, stopping)


def test_the_weights_are_those_of_the_best_epoch(tmp_path, data, stopping):
    wild = dataclasses.replace(TINY, learning_rate=0.1, epochs=12, schedule="constant")
    trained = Training(tmp_path, wild, data, stopping, held_out=NOTHING).run()
    assert trained.history[-1].accuracy < trained.best.accuracy
    found = Network(trained.arrays).probabilities_of_many(stopping.padded())
    assert accuracies(found, stopping)["all"] == pytest.approx(trained.best.accuracy)
    assert trained.best.accuracy == max(e.accuracy for e in trained.history)
    assert trained.history[-1].best == trained.best.accuracy


def test_it_ends_when_time_or_patience_is_up(tmp_path, data, stopping):
    training = Training(tmp_path / "time", TINY, data, stopping, held_out=NOTHING)
    assert len(training.run(budget=1e-9).history) == 1
    assert not training.finished
    patient = dataclasses.replace(TINY, epochs=200, patience=3)
    history = Training(tmp_path / "patience", patient, data, stopping, held_out=NOTHING)
    epochs = history.run().history
    assert len(epochs) < 200
    assert epochs[-1].number - epochs[-1].best_epoch == 3


def test_a_small_set_is_learnt_from_again_and_every_set_stops(tmp_path, data):
    """Of 60 layouts and some 9 of another set, which comes to 30 in an epoch."""
    options = dataclasses.replace(TINY, epochs=1, least_share=0.5)
    job = TrainingJob(options, data=("benchmark", "real"), limit=20)
    made = load_weights(train_weights(job, tmp_path)).manifest
    assert [source["name"] for source in made["data"]] == ["benchmark", "real"]
    assert made["cases"] == sum(source["cases"] for source in made["data"])
    assert {"benchmark", "real", "real S1"} <= set(made["validation"]["mean"])
    assert made["ranges"]["overhang"][1] > 0.0  # as in real alone
    own = dataclasses.replace(data.chosen(np.arange(len(data)) < 9), sets=np.full(9, "own"))
    both = repeated(joined([data, own]), 0.5)
    assert ((both.sets == "own").sum(), (both.sets != "own").sum()) == (36, 60)


@pytest.mark.parametrize("part", ["validation", "test"])
def test_nothing_held_out_of_any_set_is_learnt_from(tmp_path, stopping, part):
    leaky = load_sequences(FeatureKind.SUPPORT, part, directory="real", limit=5)
    with pytest.raises(LeakError, match="is held out"):
        Training(tmp_path, TINY, leaky, stopping, held_out=HeldOut.of((None, "real")))


def test_another_training_is_not_gone_on_with(tmp_path, data, stopping):
    Training(tmp_path, TINY, data, stopping, held_out=NOTHING).run(budget=1e-9)
    other = dataclasses.replace(TINY, learning_rate=2e-2)
    with pytest.raises(LearnerError, match=r"another training \(learning_rate differ\)"):
        Training(tmp_path, other, data, stopping, held_out=NOTHING)
    fewer = data.chosen(np.arange(len(data)) > 0)
    with pytest.raises(LearnerError, match=r"another training \(.*data.* differ\)"):
        Training(tmp_path, TINY, fewer, stopping, held_out=NOTHING)
    (tmp_path / CHECKPOINT).write_bytes(b"no checkpoint")
    with pytest.raises(LearnerError, match="is damaged; remove it"):
        Training(tmp_path, TINY, data, stopping, held_out=NOTHING)


def test_a_changed_bit_of_a_checkpoint_is_noticed(tmp_path, data, stopping):
    """Torch itself does not notice one in a tensor; checkpoints of before have no checksum."""
    Training(tmp_path, TINY, data, stopping, held_out=NOTHING).run(budget=1e-9)
    file = tmp_path / CHECKPOINT
    whole = file.read_bytes()
    for place in range(0, len(whole), len(whole) // 20):
        changed = bytearray(whole)
        changed[place] ^= 1
        file.write_bytes(changed)
        with pytest.raises(LearnerError, match="is damaged; remove it to start anew"):
            Training(tmp_path, TINY, data, stopping, held_out=NOTHING)
    file.write_bytes(whole[whole.index(b"PK") :])
    Training(tmp_path, TINY, data, stopping, held_out=NOTHING)


def test_nothing_that_is_held_out_can_be_learnt_from(tmp_path, data, stopping):
    with pytest.raises(LeakError, match="is held out"):
        Training(tmp_path, TINY, stopping, data, held_out=HeldOut.of())
    with pytest.raises(LeakError, match="is held out"):
        Training(tmp_path, TINY, data, data, held_out=NOTHING)
    assert not (tmp_path / CHECKPOINT).exists()


def test_a_training_starts_from_given_weights(tmp_path, data, stopping):
    first = Training(tmp_path / "first", TINY, data, stopping, held_out=NOTHING).run()
    # One epoch at next to no learning rate leaves them as they are.
    still = dataclasses.replace(TINY, epochs=1, learning_rate=1e-7)
    second = Training(
        tmp_path / "second", still, data, stopping, held_out=NOTHING, start=first.arrays
    ).run()
    for name, array in first.arrays.items():
        np.testing.assert_allclose(second.arrays[name], array, atol=1e-5)
    larger = dataclasses.replace(TINY, hidden=12)
    with pytest.raises(LearnerError, match="are of another shape"):
        Training(tmp_path / "third", larger, data, stopping, held_out=NOTHING, start=first.arrays)


def test_every_member_starts_from_its_own(tmp_path):
    """Members that all started from the first one would be one network five times."""
    job = TrainingJob(TINY, members=2, limit=10, budget=2e6)
    first = train_weights(job, tmp_path / "first")
    still = dataclasses.replace(TINY, epochs=1, learning_rate=1e-7)
    later = TrainingJob(still, members=3, limit=10, start=str(first))
    second = train_weights(later, tmp_path / "second")
    for member, of in ((0, 0), (1, 1), (2, 0)):
        for name, array in load_arrays(first, of).items():
            found = load_arrays(second, member)[name]
            np.testing.assert_allclose(found, array, atol=1e-5)
    assert "--budget 2000000 " in job.command


def test_a_finished_training_that_is_run_again_leaves_its_weights_as_they_are(tmp_path):
    """What was judged by them, and thresholds fitted to them, hang on their digest."""
    job = TrainingJob(dataclasses.replace(TINY, epochs=2), members=2, limit=10)
    first = load_weights(train_weights(job, tmp_path))
    again = load_weights(train_weights(job, tmp_path))
    assert again.digest == first.digest
    spent = sum(member["seconds"] for member in first.manifest["members"])
    assert first.manifest["seconds"] == pytest.approx(spent)


def test_what_a_killed_run_left_half_written_goes(tmp_path, data, stopping):
    left = tmp_path / f".{CHECKPOINT}.abcd1234.unfinished"
    left.write_bytes(b"half a checkpoint")
    Training(tmp_path, TINY, data, stopping, held_out=NOTHING)
    assert not left.exists()


def test_a_search_proposes_the_same_with_and_without_a_break(tmp_path, data, stopping):
    base = dataclasses.replace(TINY, epochs=1)
    given = {"held_out": NOTHING, "seed": 3}
    whole = search_hyperparameters(base, tmp_path / "one", data, stopping, trials=3, **given)
    search_hyperparameters(base, tmp_path / "two", data, stopping, trials=1, **given)
    # What a kill leaves behind: a proposal that nobody answered.
    backend = optuna.storages.journal.JournalFileBackend(str(tmp_path / "two" / JOURNAL))
    storage = optuna.storages.JournalStorage(backend)
    study = optuna.load_study(
        study_name=None, storage=storage, sampler=optuna.samplers.RandomSampler(seed=4)
    )
    left = study.ask()
    left.suggest_float("learning_rate", *LEARNING_RATES, log=True)
    left.suggest_categorical("hidden", HIDDEN)
    left.suggest_categorical("optimizer", ["adam", "adamw"])
    broken = search_hyperparameters(base, tmp_path / "two", data, stopping, trials=3, **given)
    assert broken == whole
    assert [r.accuracy for r in whole] == sorted((r.accuracy for r in whole), reverse=True)
    for result in whole:
        assert result.options.hidden in HIDDEN
        assert LEARNING_RATES[0] <= result.options.learning_rate <= LEARNING_RATES[1]
    assert len({r.options for r in whole}) == 3
    with pytest.raises(LearnerError, match=r"another search \(seed differ\)"):
        search_hyperparameters(
            base, tmp_path / "two", data, stopping, trials=3, held_out=NOTHING, seed=4
        )


def test_a_search_keeps_to_what_its_network_allows(tmp_path, data, stopping):
    base = dataclasses.replace(TINY, epochs=1, network=NetworkKind.ATTENTION)
    found = search_hyperparameters(
        base, tmp_path, data, stopping, held_out=NOTHING, trials=6, seed=1
    )
    assert {result.options.hidden for result in found} == {100, 200}


def test_a_search_and_its_training_share_the_budget(tmp_path):
    options = dataclasses.replace(TINY, epochs=1)
    job = TrainingJob(options, limit=10, budget=100.0)
    found = search_options(job, tmp_path, 1)
    assert found.budget == 50.0
    assert dataclasses.replace(found, options=options, budget=100.0) == job


def test_data_of_which_nothing_is_left_say_so(tmp_path):
    """A copy of held-out layouts under another name: all are twins, and let go."""
    shipped = load_benchmark()
    held = shipped.select("test", limit=4, scenarios=("S1",))
    layouts = shipped.layouts.loc[held["layout"]].reset_index().assign(instance="mine")
    cases = held.assign(split="train")[CASES.names]
    empty = pd.DataFrame({name: [] for name in OPINIONS.names})
    write_tables(tmp_path / "copy", layouts, cases, empty, {"seed": 7})
    job = TrainingJob(TINY, data=(str(tmp_path / "copy"),))
    with pytest.raises(LearnerError, match=r"4 of 4 layouts are geometries of held-out layouts"):
        train_weights(job, tmp_path / "training")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"hiden": 8}, "unknown parameter 'hiden'; did you mean 'hidden'"),
        ({"hidden": 0}, "hidden is 0; allowed: a whole number, 1 to 4,096"),
        ({"optimizer": "sgd"}, "optimizer is 'sgd'; allowed: adam, adamw"),
        ({"network": "attention", "hidden": 30}, "hidden is 30; allowed: a multiple of 4"),
        ({"symmetries": 9}, "symmetries is 9; allowed: a whole number, 1 to 8"),
    ],
)
def test_options_that_cannot_be(values, message):
    with pytest.raises(LearnerError, match=message):
        options_from(values, where="here")


def test_a_learning_rate_stays_or_goes_down_half_a_cosine_to_a_hundredth():
    options = TrainingOptions(schedule=Schedule.COSINE, epochs=40)
    assert [_rate(options, epoch) for epoch in (0, 10, 20, 40)] == pytest.approx(
        [1.0, 0.01 + 0.99 * 0.5 * (1.0 + 0.5**0.5), 0.505, 0.01]
    )
    constant = dataclasses.replace(options, schedule=Schedule.CONSTANT)
    assert _rate(constant, 17) == 1.0


def test_presets_and_members():
    paper = training_preset("paper").options
    assert (paper.features, paper.hidden, paper.learning_rate) == ("plain", 125, 3.5e-4)
    assert (paper.epochs, paper.layers, paper.optimizer) == (700, 2, "adam")
    assert training_preset("quick").budget <= 600.0
    with pytest.raises(LearnerError, match="did you mean 'quick'"):
        training_preset("quik")
    for preset in training_presets().values():
        job = TrainingJob.of(preset, {})
        members = [job.member_options(k) for k in range(preset.members)]
        assert len({m.seed for m in members}) == preset.members
        assert members[0].seed == preset.options.seed


def test_members_of_the_papers_ensemble_have_sizes_and_rates_of_their_own():
    """Table 4; its first network is that of LSTM_1."""
    preset = training_preset("paper-ensemble")
    job = TrainingJob.of(preset, {"seed": "3"})
    members = [job.member_options(k) for k in range(5)]
    assert [member.hidden for member in members] == [125, 175, 150, 150, 200]
    assert members[0] == TrainingJob.of(training_preset("paper"), {"seed": "3"}).options
    assert "--preset paper-ensemble " in job.command
    assert "hidden" not in job.command
    with pytest.raises(LearnerError, match="hidden is given; preset paper-ensemble has one for"):
        TrainingJob.of(preset, {"hidden": "64"})
    with pytest.raises(LearnerError, match="members is 6; allowed: 1 to 5"):
        TrainingJob.of(preset, {}, members=6)


def test_networks_of_different_sizes_are_trained_and_read_again(tmp_path):
    job = TrainingJob.of(
        training_preset("paper-ensemble"), {"epochs": "1"}, members=2, limit=3, budget=1e6
    )
    found = load_weights(train_weights(job, tmp_path))
    assert [m["options"]["hidden"] for m in found.manifest["members"]] == [125, 175]
    with pytest.raises(LearnerError, match="a search chooses the hidden size"):
        search_options(job, tmp_path / "search", 2)
