"""The timing pass: equal layouts for all, in turns, kept, and taken again only when needed."""

import sys
import time
import types
from dataclasses import dataclass

import pytest

from steadyload.engines.quantities import quantity
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import registry
from steadyload.methods.contract.method import STABLE, Method
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.results import ResultsError
from steadyload.runs.store import JSON, Store
from steadyload.runs.timing import taken, timed, timed_batches

METHODS = ("noting", "noting:mark=1", "noting:mark=2")


@dataclass(frozen=True)
class NoteParameters:
    mark: int = quantity(0, "tells one from another", least=0)


class Noting(Method):
    """Notes what it is asked, in this process."""

    Parameters = NoteParameters
    asked: list[tuple[str, str]]

    def _judge(self, layout, watch):
        self.asked.append((str(self.spec), layout.name))
        return STABLE


@pytest.fixture
def asked(monkeypatch):
    Noting.asked = []
    monkeypatch.setitem(sys.modules, "noting_judge", types.SimpleNamespace(Noting=Noting))
    monkeypatch.setitem(registry.METHODS, "noting", "noting_judge:Noting")
    return Noting.asked


@pytest.fixture(scope="module")
def layouts():
    return random_layouts(7, seed=4)


def test_every_method_judges_the_same_layouts_as_often(asked, layouts, tmp_path):
    times = timed(METHODS, layouts, tmp_path, repeats=3, block=3, workers=0)
    for found in (times.cpu, times.wall):
        assert list(found) == list(METHODS)
        assert {of.shape for of in found.values()} == {(3, 7)}
        assert all((of >= 0.0).all() for of in found.values())
    by_method = {spec: [name for of, name in asked if of == spec] for spec in METHODS}
    assert by_method[METHODS[0]] == by_method[METHODS[1]] == by_method[METHODS[2]]
    names = [layout.name for layout in layouts]
    # Each layout once a repeat; the first of each block once more, untimed.
    assert all(by_method["noting"].count(name) >= 3 for name in names)
    assert len(by_method["noting"]) == 3 * (7 + 3)


def test_a_method_has_a_block_in_a_turn_and_no_method_is_always_first(asked, layouts, tmp_path):
    timed(METHODS, layouts, tmp_path, repeats=1, block=3, workers=0)
    turns = [spec for spec, _ in asked]
    changes = [spec for k, spec in enumerate(turns) if k == 0 or turns[k - 1] != spec]
    blocks = [tuple(changes[k : k + 3]) for k in range(0, 9, 3)]
    assert all(set(block) == set(METHODS) for block in blocks)
    assert {block[0] for block in blocks} == set(METHODS)


def test_times_stand_beside_their_method_and_layout(asked, layouts, tmp_path, monkeypatch):
    def told(work):
        method, layout = work.args
        return float(len(layout)), float(method.parameters.mark)

    monkeypatch.setattr("steadyload.runs.timing.taken", told)
    times = timed(METHODS, layouts, tmp_path, repeats=2, block=3, workers=0)
    for mark, spec in enumerate(METHODS):
        assert times.cpu[spec].tolist() == 2 * [[len(layout) for layout in layouts]]
        assert times.wall[spec].tolist() == 2 * [[mark] * len(layouts)]


def test_a_block_that_was_taken_is_not_taken_again(asked, layouts, tmp_path, monkeypatch):
    first = timed(METHODS, layouts, tmp_path, repeats=2, block=3, workers=0)
    asked.clear()
    again = timed(METHODS, layouts, tmp_path, repeats=2, block=3, workers=0)
    assert asked == []
    assert {k: v.tolist() for k, v in again.cpu.items()} == {
        k: v.tolist() for k, v in first.cpu.items()
    }
    told = []
    more = timed(METHODS, layouts, tmp_path, repeats=3, block=3, workers=0,
                 progress=lambda done, total: told.append((done, total)))  # fmt: skip
    assert told == [(6, 9), (7, 9), (8, 9), (9, 9)]
    assert more.cpu["noting"][:2].tolist() == first.cpu["noting"].tolist()
    asked.clear()
    timed(METHODS, layouts[1:], tmp_path, repeats=1, block=3, workers=0)
    assert asked  # times of other blocks are other times
    asked.clear()
    monkeypatch.setattr(Noting, "version", 2)
    timed(METHODS, layouts, tmp_path, repeats=1, block=3, workers=0)
    assert asked


def test_kept_times_name_their_cases_and_the_code_and_machine_that_took_them(
    asked, layouts, tmp_path
):
    times = timed(METHODS, layouts, tmp_path / "turns", repeats=1, block=3, workers=0)
    learned = layouts[:2]
    timed_batches(["lstm_1"], learned, tmp_path / "batches", repeats=1, batches=(2,), workers=0)
    here = provenance_lines()
    assert times.made_with == here
    for folder, of in (("turns", layouts), ("batches", learned)):
        store = Store(tmp_path / folder, JSON)
        rows = [row for key in store.keys() for row in store.read(key)]  # noqa: SIM118
        named = {tuple(case) for row in rows for case in row["cases"]}
        assert named == {(layout.name, layout.content_hash()) for layout in of}
        for row in rows:
            assert row["made_with"] == here
            for clock in ("cpu", "wall"):
                assert {len(own) for own in row.get(clock, {}).values()} <= {len(row["cases"])}


def test_an_interrupted_pass_goes_on_with_the_block_that_is_missing(asked, layouts, tmp_path):
    def stop(done, total):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        timed(METHODS, layouts, tmp_path, repeats=1, block=3, workers=0, progress=stop)
    asked.clear()
    timed(METHODS, layouts, tmp_path, repeats=1, block=3, workers=0)
    assert {name for _, name in asked} == {layouts[-1].name}


def test_the_load_is_the_largest_of_all_blocks(asked, layouts, tmp_path):
    timed(METHODS[:1], layouts, tmp_path, repeats=2, workers=0)
    store = Store(tmp_path, JSON)
    for load, key in zip((0.4, 2.5), sorted(store.keys()), strict=True):
        [found] = store.read(key)
        store.write(key, [found | {"load": load}])
    assert timed(METHODS[:1], layouts, tmp_path, repeats=2, workers=0).load == 2.5


def test_a_method_that_ends_its_process_is_named(outside, layouts, tmp_path):
    bad = [layout for layout in random_layouts(3, seed=1) if layout.name == outside.BAD]
    with pytest.raises(ResultsError, match=r"timing 1 methods on 1 layouts.*SIGABRT"):
        timed(["harmful:harm=abort"], bad, tmp_path, repeats=1, workers=1)


def test_sleeping_takes_wall_time_and_no_cpu_time():
    cpu, wall = taken(lambda: time.sleep(0.05))
    assert wall >= 50.0
    assert cpu < wall


def test_times_are_in_milliseconds():
    def busy():
        end = time.process_time() + 0.02
        while time.process_time() < end:
            pass

    assert all(measured >= 20.0 for measured in taken(busy))
