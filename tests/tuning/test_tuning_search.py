"""Proposers, whole searches on an engine, and the presets that come of them."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from steadyload.methods.registry import make_method
from steadyload.studies.tuning.searching import of_searches, searching
from steadyload.tuning import TuningError, trial
from steadyload.tuning.cases import CaseSource
from steadyload.tuning.cost import CostModel
from steadyload.tuning.ledger import GenerationEnd, Ledger
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.proposers import ALGORITHMS, Genetic
from steadyload.tuning.search import Search
from steadyload.tuning.space import space_on
from steadyload.tuning.trial import fitness

MODEL = CostModel(
    {
        "layout": 100.0, "world": 200.0, "world with the simple broad phase": 0.0,
        "box placed": 10.0, "look": 10.0, "substep": 20.0, "body and substep": 1.0,
        "body and substep, neighbours close": 1.0,
        "body, substep and iteration": 0.05,
    }
)  # fmt: skip
"""Stated, so that costs are the same in every run: measured ones never are."""

OPTIONS = SearchOptions(
    "mujoco", population=6, generations=3, seed=3, source=CaseSource(limit=8), model=MODEL
)
CASES = 24


def searched(folder, algorithm):
    search = Search(folder, dataclasses.replace(OPTIONS, algorithm=algorithm))
    search.run(workers=0)
    return search, folder


@pytest.fixture(scope="module")
def genetic(tmp_path_factory):
    """A search that nothing interrupted, judged in this process, and its folder."""
    return searched(tmp_path_factory.mktemp("genetic"), "genetic")


@pytest.fixture(scope="module")
def multi_objective(tmp_path_factory):
    """The same by the other algorithm."""
    return searched(tmp_path_factory.mktemp("nsga2"), "nsga2")


@pytest.fixture(params=["genetic", "multi_objective"])
def finished(request):
    """A finished search and its folder, for either algorithm."""
    return request.getfixturevalue(request.param)


def verdicts(folder):
    ledger = Ledger.of(folder)[1]
    entries = {
        g: (e.generation, e.trial.right.tolist(), e.trial.cost.tolist(), e.trial.reason)
        for g, e in ledger.entries.items()
    }
    return entries, [(end.number, end.asked, end.median) for end in ledger.ends]


# --- proposers ----------------------------------------------------------------------------------


def test_a_genotype_that_is_two_per_cent_fitter_is_drawn_twenty_times_as_often():
    wheel, proposer = [], object.__new__(Genetic)
    proposer._line = SimpleNamespace(send=wheel.extend)
    proposer.tell([(0.9, 0.8, 1.0), (0.9 / 1.02, 0.9, 0.1), (0.45, 1.0, 1.0)])
    assert wheel[0] / wheel[1] == pytest.approx(1.02**150)
    assert 19.0 < wheel[0] / wheel[1] < 20.0
    assert wheel[2] < 1e-40 * wheel[0]


def proposals(name, seed, generations=3):
    """What is proposed when it is told what could have been found."""
    space = space_on("mujoco")
    proposer = ALGORITHMS[name](space, 8, seed)
    found = []
    try:
        for _ in range(generations):
            found.append(proposer.ask())
            shares = [np.mean(np.divide(g, [len(x.values) for x in space.genes]))
                      for g in found[-1]]  # fmt: skip
            proposer.tell([(0.5 + share / 2, 1 - share, 1 + 5 * share) for share in shares])
    finally:
        proposer.close()
    return space, found


@pytest.mark.parametrize("name", sorted(ALGORITHMS))
def test_proposals_are_fixed_by_the_seed(name):
    space, found = proposals(name, seed=1)
    assert space.start in found[0]
    assert len(found[0]) == 8
    for genotype in (g for generation in found for g in generation):
        assert len(genotype) == len(space.genes)
        for gene, at in zip(space.genes, genotype, strict=True):
            assert type(at) is int
            assert 0 <= at < len(gene.values)
    assert len({g for generation in found for g in generation}) > 12
    assert proposals(name, seed=1)[1] == found
    other = proposals(name, seed=2, generations=1)[1]
    assert set(other[0]) & set(found[0]) == {space.start}


# --- a search -----------------------------------------------------------------------------------


def test_a_search_never_ends_below_its_start_nor_falls(finished):
    search, _ = finished
    start = search.ledger.entries[search.space.start]
    assert len(start.trial) == len(search.cases) == CASES
    best = [fitness(search.fittest(n).trial, search.goal) for n in range(4)]
    assert best[0] == fitness(start.trial, search.goal)
    assert best == sorted(best)
    found = {fitness(e.trial, search.goal) for e in search.whole()}
    assert min(found) < best[0], "nothing to lose"
    assert search.fittest() == search.fittest(3)
    assert all(fitness(e.trial, search.goal) <= best[-1] for e in search.whole())
    row = searching(search)
    assert [g.best for g in row.history] == best[1:]
    volumes = [g.volume for g in row.history]
    assert volumes == sorted(volumes)
    assert row.hypervolume == volumes[-1]


def test_every_genotype_is_judged_once_and_as_its_spec_says(finished):
    search, folder = finished
    lines = [json.loads(line) for line in (folder / "search.jsonl").read_text().splitlines()]
    written = [tuple(line["genotype"]) for line in lines if "genotype" in line]
    assert len(written) == len(set(written)) == len(search.ledger.entries)
    row = searching(search)
    asked = sum(end.asked for end in search.ledger.ends)
    assert row.genotypes + row.repeats == asked + 1, "the start is judged unasked, then proposed"
    assert row.repeats >= 1
    assert {len(e.trial) for e in search.judged()} <= {30, CASES}
    best = search.fittest()
    method = make_method(search.space.spec(best.genotype))
    said = [method.judge(case.layout) for case in search.cases]
    safe = [v.item_count if v.failing_step is None else v.failing_step for v in said]
    right = [s == case.safe for s, case in zip(safe, search.cases, strict=True)]
    assert right == best.trial.right.tolist()
    costs = [MODEL.milliseconds(v.effort, method.parameters) for v in said]
    np.testing.assert_allclose(best.trial.cost, costs, atol=1e-4)


SCRIPT = """
import sys
from pathlib import Path
from types import SimpleNamespace
from steadyload.tuning.cases import CaseSource
from steadyload.tuning.cost import CostModel
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.search import Search

if __name__ == "__main__":
    options = SearchOptions(
        "mujoco", population=6, generations=3, seed=3,
        source=CaseSource(limit=8), model=CostModel({model}),
    )
    Search(Path(sys.argv[1]), options).run(workers=int(sys.argv[2]))
"""


def test_a_killed_search_ends_as_if_nothing_had_been(tmp_path, genetic):
    """SIGKILL in the second generation; then over two processes, in whatever order they answer."""
    search, folder = genetic
    script, run = tmp_path / "script.py", tmp_path / "run"
    script.write_text(SCRIPT.replace("{model}", repr(MODEL.microseconds)))
    command = [sys.executable, str(script), str(run)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen([*command, "0"], env=environment, start_new_session=True)
    file = run / "search.jsonl"
    while process.poll() is None and not (file.exists() and b'"end": 0' in file.read_bytes()):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    entries, ends = verdicts(run)
    assert 1 <= len(ends) < 3, "killed too early or too late to tell"
    assert len(entries) < len(search.ledger.entries)
    while processes_of(process.pid):  # whoever proposes ends by itself
        time.sleep(0.02)
    subprocess.run([*command, "2"], env=environment, check=True)
    assert verdicts(run) == verdicts(folder)
    assert Search.of(run).fittest().genotype == search.fittest().genotype


def processes_of(session):
    """The processes of a session, without those that have ended."""
    found = subprocess.run(["ps", "-eo", "sid=,stat="], capture_output=True, text=True, check=True)
    rows = [line.split() for line in found.stdout.splitlines()]
    return [stat for sid, stat in rows if sid == str(session) and not stat.startswith("Z")]


def test_a_search_goes_on_from_any_line(finished, tmp_path):
    """Cut off in the middle of a line of the second generation, and gone on with here."""
    search, folder = finished
    whole = (folder / "search.jsonl").read_bytes()
    lines = whole.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if b'"generation": 1' in line)
    (tmp_path / "search.jsonl").write_bytes(b"".join(lines[: at + 1]) + lines[at + 1][:20])
    Search(tmp_path, search.options).run(workers=0)
    assert verdicts(tmp_path) == verdicts(folder)
    again = (tmp_path / "search.jsonl").read_bytes().splitlines()
    assert len(again) == len(lines), "nothing is judged twice"


def test_what_an_unfinished_generation_found_does_not_count(finished, tmp_path):
    """The best genotype again, as if its generation had been interrupted."""
    search, folder = finished
    lines = (folder / "search.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "search.jsonl").write_text("".join(lines[:-1]))
    cut = Search.of(tmp_path)
    assert max(e.generation for e in cut.judged()) == 1
    assert searching(cut).population == (6, 2)
    assert searching(cut).repeats >= 1
    assert len(cut.judged()) < len(cut.ledger.entries) == len(search.ledger.entries)


def test_the_order_of_answers_decides_nothing(finished, tmp_path):
    search, folder = finished
    lines = (folder / "search.jsonl").read_text().splitlines(keepends=True)
    judged = [line for line in lines if '"genotype"' in line]
    others = [line for line in lines if '"genotype"' not in line]
    (tmp_path / "search.jsonl").write_text("".join([*others, *reversed(judged)]))
    turned = Search.of(tmp_path)
    assert [e.genotype for e in turned.judged()] == [e.genotype for e in search.judged()]
    assert turned.fittest().genotype == search.fittest().genotype


def test_a_genotype_beyond_its_hard_limit_is_worth_nothing(genetic, monkeypatch):
    search, _ = genetic
    monkeypatch.setattr(trial, "hard_seconds", lambda timeout: 1e-6 * timeout)
    spec = search.space.spec(search.space.start)
    found = search._judge({"start": spec}, search._race(1), 1)["start"]
    assert len(found) == 0
    assert found.reason.startswith(f"{spec}: no answer within 0.00")


def test_a_budget_ends_a_search_over_all_its_starts(tmp_path):
    options = dataclasses.replace(OPTIONS, generations=None, budget=1e-3, population=4)
    search = Search(tmp_path, options)
    search.run(workers=0)
    assert len(search.ledger.ends) == 1, "one generation is always judged"
    before = verdicts(tmp_path)
    Search(tmp_path, options).run(workers=0)
    assert verdicts(tmp_path) == before


@pytest.mark.parametrize(("budget", "ends"), [(3.5, True), (6.0, True), (6.5, False)])
def test_a_budget_is_of_all_generations_together(tmp_path, budget, ends):
    search = Search(tmp_path, dataclasses.replace(OPTIONS, generations=None, budget=budget))
    for number, wall in enumerate((2.0, 3.0, 1.0)):
        search.ledger.end(GenerationEnd(number, 4, 0.5, wall))
    assert search._finished(3) == ends


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"algorithm": "genetics"}, "unknown algorithm 'genetics'; did you mean 'genetic'?"),
        ({"population": 3}, "population is 3; allowed: 4 or more"),
        (
            {"begin_with": ("label@mujoco",) * 6},
            "6 parameter sets to begin with; allowed: fewer than",
        ),
        ({"generations": None}, "needs a number of generations or a budget"),
    ],
)
def test_wrong_options_are_refused(change, message):
    with pytest.raises(TuningError) as caught:
        dataclasses.replace(OPTIONS, **change)
    assert message in str(caught.value)


def test_a_search_without_its_start_is_no_record(finished, tmp_path):
    _, folder = finished
    first = (folder / "search.jsonl").read_text().splitlines(keepends=True)[0]
    (tmp_path / "search.jsonl").write_text(first)
    with pytest.raises(TuningError, match="has not judged its start yet"):
        Search.of(tmp_path)


def test_a_record_of_searches_holds_what_they_found(finished):
    search, _ = finished
    record = of_searches([search])
    [one], genes = record["searches"], record["genes"]
    assert (one.engine, one.goal) == ("mujoco", search.goal)
    assert one.cases == f"{CASES} of part `validation` of the large set"
    assert one.changed == (sum(gene.start != gene.found["mujoco"] for gene in genes), len(genes))
    names = [gene.name.partition(" ")[0] for gene in genes]
    best = search.space.values(search.fittest().genotype)
    found = [float(gene.found["mujoco"]) for gene in genes]
    assert dict(zip(names, found, strict=True)) == pytest.approx(best)
    assert {
        name: float(gene.start) for name, gene in zip(names, genes, strict=True)
    } == pytest.approx(search.space.values(search.space.start))
    assert search.made_by["versions"][ALGORITHMS[search.options.algorithm].needs]
