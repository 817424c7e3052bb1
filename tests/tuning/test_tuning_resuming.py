"""Searches that go on, or are made again, where that would not be the same search."""

import dataclasses
import json
import multiprocessing
import os
import signal
import time
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.methods import tuned
from steadyload.methods.tuned import write_tuned
from steadyload.runs import provenance
from steadyload.studies.tuning.comparing import apart_by_seeds
from steadyload.tuning import TuningError, identity
from steadyload.tuning import search as searching
from steadyload.tuning.cases import CaseSource, load_cases
from steadyload.tuning.cost import TERMS, CostModel
from steadyload.tuning.ledger import Ledger
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.presets import preset
from steadyload.tuning.proposers import Genetic
from steadyload.tuning.search import Search
from steadyload.tuning.space import space_on

MODEL = CostModel(dict.fromkeys(TERMS, 0.0) | {"layout": 500.0, "substep": 20.0}, 24, 0.9, 0.1)

OPTIONS = SearchOptions(
    "mujoco", population=4, generations=1, seed=1, source=CaseSource(limit=2), model=MODEL
)


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """The text of the file of a finished search."""
    folder = tmp_path_factory.mktemp("search")
    Search(folder, OPTIONS).run(workers=0)
    return (folder / "search.jsonl").read_text()


def test_a_search_whose_generations_would_be_others_is_refused(searched, tmp_path):
    """As if PyGAD proposed another genotype than when the generation was judged."""
    lines = searched.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if '"generation": 0' in line)
    (tmp_path / "search.jsonl").write_text("".join(lines[:at] + lines[at + 1 :]))
    with pytest.raises(TuningError, match=r"generation 0 would be another one now.* with pygad "):
        Search(tmp_path, dataclasses.replace(OPTIONS, generations=2)).run(workers=0)


def test_another_model_of_cost_is_another_search(searched, tmp_path):
    (tmp_path / "search.jsonl").write_text(searched)
    dearer = dataclasses.replace(MODEL, microseconds={**MODEL.microseconds, "look": 1.0})
    with pytest.raises(TuningError, match="holds a search with another model of cost"):
        Search(tmp_path, dataclasses.replace(OPTIONS, model=dearer)).run(workers=0)
    Search(tmp_path, OPTIONS).run(workers=0)
    assert (tmp_path / "search.jsonl").read_text() == searched


def test_a_labelled_set_that_has_changed_is_refused(searched, tmp_path, monkeypatch):
    """One label is another one now."""
    (tmp_path / "search.jsonl").write_text(searched)
    first, *others = load_cases(OPTIONS.source)
    relabelled = (dataclasses.replace(first, safe=first.safe - 1), *others)
    search = Search(tmp_path, OPTIONS)
    monkeypatch.setattr(search, "cases", relabelled)
    with pytest.raises(TuningError, match="the labelled set has changed"):
        search.run(workers=0)


def test_code_that_changes_under_a_search_ends_it(tmp_path, monkeypatch):
    """As if an adapter were edited while workers, which read it anew, are being started."""
    search = Search(tmp_path, OPTIONS)
    judge = searching.run_units

    def edited_meanwhile(*given, **options):
        monkeypatch.setattr(identity, "made_by", lambda method: "of another version")
        yield from judge(*given, **options)

    monkeypatch.setattr(searching, "run_units", edited_meanwhile)
    with pytest.raises(TuningError, match="code was changed while the search was running"):
        search.run(workers=0)
    assert not search.ledger.ends


def test_a_ledger_is_begun_by_its_first_line(tmp_path):
    """Two that are opened at once, of which one is locked out, must not both begin it."""
    first, _ = (Ledger(tmp_path, {"engine": "mujoco"}) for _ in range(2))
    assert not list(tmp_path.iterdir())
    first.state("goal", 1.0)
    assert Ledger(tmp_path, {"engine": "mujoco"}).facts == {"goal": 1.0}
    with pytest.raises(TuningError, match="engine differ"):
        Ledger(tmp_path, {"engine": "dart"})


def test_a_number_that_has_changed_is_noticed(searched, tmp_path):
    lines = searched.splitlines(keepends=True)
    for at in (k for k, line in enumerate(lines) if '"cost"' in line and '"search"' not in line):
        changed = lines[at].replace('"cpu": 0', '"cpu": 1')
        assert changed != lines[at]
        (tmp_path / "search.jsonl").write_text("".join([*lines[:at], changed, *lines[at + 1 :]]))
        with pytest.raises(TuningError, match=r"search\.jsonl: is damaged"):
            Search.of(tmp_path)


def test_a_search_is_kept_to_be_read(searched, tmp_path):
    run, kept = tmp_path / "run", tmp_path / "kept"
    run.mkdir()
    (run / "search.jsonl").write_text(searched)
    Search.of(run).ledger.keep(kept)
    (file,) = kept.iterdir()
    assert file.stat().st_size < len(searched) / 2
    there, here = Search.of(run), Search.of(kept)
    assert here.fittest().genotype == there.fittest().genotype
    assert here.ledger.facts == there.ledger.facts
    assert list(here.ledger.entries) == list(there.ledger.entries)
    again = tmp_path / "again"
    here.ledger.keep(again)
    assert (again / file.name).read_bytes() == file.read_bytes()
    with pytest.raises(TuningError, match="unpack it"):
        here.ledger.state("goal", 1.0)
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(TuningError, match="is damaged"):
        Search.of(kept)
    (kept / "search.jsonl").write_text(searched)
    Search.of(kept).ledger.state("goal", 1.0)


def test_seeds_are_told_where_searches_began_with_nothing(searched, tmp_path):
    """Whatever a search begins with it finds again, with any seed."""
    first, rest = searched.split("\n", 1)

    def search(seed, **others):
        begun = json.loads(first)
        begun["search"].update(seed=seed, **others)
        folder = tmp_path / f"{seed}-{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        (folder / "search.jsonl").write_text(json.dumps(begun) + "\n" + rest)
        return Search.of(folder)

    def seeds(*searches):
        return [found.options.seed for found, _ in apart_by_seeds(searches)]

    known = {"begin_with": ["ps3@mujoco"]}
    led = [search(seed, **known) for seed in (0, 1, 2)]
    free = [search(seed) for seed in (5, 4)]
    assert seeds(*led, *free) == [4, 5]
    assert seeds(*led, free[0]) == [0, 1, 2]
    assert seeds(led[0], free[0], search(6, population=77)) == []


def test_a_search_keeps_its_goal(searched, tmp_path, monkeypatch):
    """Whatever share of PS_3's cost later searches go for."""
    (tmp_path / "search.jsonl").write_text(searched)
    goal = Search.of(tmp_path).goal
    monkeypatch.setattr(searching, "GOAL_SHARE", 0.5)
    assert Search.of(tmp_path).goal == goal


def test_what_is_remade_is_compared_before_it_is_written(
    searched, tmp_path, monkeypatch, capfd, in_this_process
):
    """The preset at hand is not what the search finds."""
    monkeypatch.setattr(tuned, "FILE", tmp_path / "tuned.json")
    monkeypatch.setattr(provenance, "_git_revision", lambda: "0123456789ab")
    (tmp_path / "search.jsonl").write_text(searched)
    found = preset(Search.of(tmp_path))
    other = dataclasses.replace(found, parameters={**found.parameters, "eps_t": 99})
    write_tuned("within", "mujoco", other)
    command = ["tune", "--remake", "ps_opt@mujoco", "--write-preset", "-j", "1"]
    assert main([*command, "-o", str(tmp_path / "remade")]) == 1
    assert "eps_t is" in capfd.readouterr().err
    assert tuned.tuned()["mujoco"].parameters == found.parameters


def test_whoever_proposes_leaves_an_interrupt_to_others():
    """Ctrl-C reaches it, too; its traceback would stand among the sentences of the command."""
    before = set(multiprocessing.active_children())
    proposer = Genetic(space_on("mujoco"), 4, 0)
    [process] = set(multiprocessing.active_children()) - before
    first = proposer.ask()
    os.kill(process.pid, signal.SIGINT)
    time.sleep(0.2)
    proposer.tell([(0.5, 0.5, 1.0)] * len(first))
    assert proposer.ask()
    proposer.close()
    assert not process.is_alive()


PUBLISHED = Path(__file__).parents[2] / "reports" / "published" / "tuning" / "searches"


@pytest.mark.parametrize("folder", sorted(PUBLISHED.iterdir()), ids=lambda folder: folder.name)
def test_a_published_search_can_be_gone_on_with(folder):
    """Unless a part was raised since: its verdicts would be those of two versions."""
    found, _ = Ledger.of(folder)
    options = SearchOptions(
        found["engine"], algorithm=found["algorithm"], space=found["space"], seed=found["seed"],
        population=found["population"], generations=1, begin_with=tuple(found["begin_with"]),
        source=CaseSource(**found["source"]), goal=found.get("goal"),
    )  # fmt: skip
    now = identity.identity(options, space_on(options.engine, options.space))
    made, made_now = found.pop("made_by"), now.pop("made_by")
    assert found == now
    packages = {name for name in made if not name.startswith(("version of ", "parameters"))}
    differs = {k for k in {*made, *made_now} - packages if made.get(k) != made_now.get(k)}
    assert differs <= {"version of engine"}
    if differs:
        assert made["version of engine"] < made_now["version of engine"]
