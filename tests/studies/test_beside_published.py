"""Methods of one's own beside those of a published page, whose kept rows are read."""

import numpy as np
import pandas as pd
import pytest

import steadyload as sl
from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.registry import make_method
from steadyload.studies.evaluation.study import Evaluation
from steadyload.studies.kit import Lab

OWN, LIMIT = "equilibrium:margin=0.02", 10


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("beside"), workers=0)
    return Evaluation(published=True, methods=(OWN,), limit=LIMIT).run(lab)


@pytest.fixture(scope="module")
def cases():
    return load_benchmark("lists").select("test", limit=LIMIT).set_index(KEYS)


def test_published_methods_have_their_kept_verdicts_on_the_same_cases(found, cases):
    kept = sl.rows("evaluation")
    kept = kept[(kept["run"] == "spatial") & (kept["question"] == "within")].set_index(KEYS)
    kept = kept[kept.index.isin(cases.index)]
    placed = kept["failing_step"].fillna(kept["item_count"])
    label = kept["label_within"].fillna(kept["item_count"])
    right = ((kept["status"] == "done") & (placed == label)).groupby(kept["method"]).mean()
    rows = found.sets[0]["rows"].drop(index=OWN)
    assert len(rows) > 20
    for method, own in rows.iterrows():
        assert own["right"].n == 3 * LIMIT
        assert own["right"].value == pytest.approx(right[method])
    times = kept["timed_cpu_ns"].groupby(kept["method"]).mean() / 1e6
    for method, cpu in rows["cpu"].dropna().items():
        assert cpu.value == pytest.approx(times[method])


def test_the_own_method_is_judged_here_on_these_cases(found, cases):
    benchmark, judge = load_benchmark("lists"), make_method(OWN)
    steps = pd.Series(
        [judge.judge(benchmark.layout(*case)).failing_step for case in cases.index],
        cases.index, dtype="Int64",
    )  # fmt: skip
    right = np.mean(steps.fillna(-1).to_numpy() == cases["failing_step"].fillna(-1).to_numpy())
    own = found.sets[0]["rows"].loc[OWN]
    assert own["right"].value == pytest.approx(right)
    assert own["cpu"].n == own["right"].n


def test_the_page_says_whose_times_they_are(found):
    page = Evaluation(published=True, methods=(OWN,), limit=LIMIT).page(found)
    text = " ".join(str(block) for part in page.sections for block in part.blocks)
    assert "Times of the published methods are kept ones, of another machine" in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "--published shows methods beside the published ones; name them: -m"),
        (["-m", OWN, "--directory", "lists"], "leave --directory and --timeout out"),
        (["-m", OWN, "--timeout", "3"], "leave --directory and --timeout out"),
    ],
)
def test_what_does_not_go_with_it_is_refused(words, message, capsys, tmp_path):
    assert main(["study", "evaluation", "--published", *words, "--work", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_methods_that_the_page_has_are_not_judged_again(capsys, tmp_path):
    work = tmp_path / "work"
    assert main(["study", "evaluation", "--published", "-m", "sme", "--work", str(work)]) == 2
    assert "methods sme: the published page has them all; name another" in capsys.readouterr().err


def test_without_kept_rows_the_missing_file_is_named(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["study", "evaluation", "--published", "-m", OWN, "--work", "work"]) == 2
    assert "evaluation.parquet: does not exist; rows come with a clone" in capsys.readouterr().err
