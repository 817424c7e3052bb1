"""The shipped set that searches and fits choose on: lists that no judge has learnt from."""

from itertools import combinations

import pytest

from steadyload.layouts.benchmark import CHOOSING, load_benchmark
from steadyload.layouts.benchmark.dataset import LISTS
from steadyload.layouts.benchmark.tables import write_tables
from steadyload.methods.contract.verdict import Status
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.fitted import FitOptions
from steadyload.tuning.cases import load_cases, own_part
from steadyload.tuning.options import SearchOptions

PARTS, PER_CLASS, CASES_OF_LIST = ("search", "fitting"), 10, 36


@pytest.fixture(scope="module")
def choosing():
    return load_benchmark(CHOOSING)


@pytest.mark.parametrize("part", PARTS)
def test_each_part_has_ten_lists_a_class_and_is_half_stable(choosing, part):
    cases = choosing.select(part)
    classes = cases.drop_duplicates("instance")["instance"].str.split("_").str[1]
    assert classes.value_counts().to_dict() == dict.fromkeys("123", PER_CLASS)
    assert cases.groupby("instance").size().max() <= CASES_OF_LIST
    stable = cases["failing_step"].isna()
    assert stable.groupby(cases["scenario"]).mean().eq(0.5).all()
    first = choosing.select(part, limit=60)
    assert first["failing_step"].isna().groupby(first["scenario"]).mean().eq(0.5).all()


def test_no_list_is_in_two_parts_or_in_another_set(choosing):
    of_part = [set(choosing.select(part)["instance"]) for part in PARTS]
    others = [set(load_benchmark(name).layouts["instance"]) for name in (None, LISTS)]
    for one, other in combinations([*of_part, *others], 2):
        assert not one & other


def test_no_geometry_is_in_the_large_set_or_among_the_test_lists(choosing):
    def geometries(benchmark):
        return {benchmark.layout(n, "S1").geometry_hash() for n in benchmark.layouts.index}

    found = geometries(choosing)
    assert len(found) == len(choosing.layouts)
    assert not any(found & geometries(load_benchmark(name)) for name in (None, LISTS))


def test_almost_every_case_has_labels_of_both_questions(choosing):
    assert (choosing.cases["status"] == Status.DONE).mean() > 0.999
    chosen = choosing.cases["split"].notna().sum()
    assert (choosing.stands["status"] == Status.DONE).sum() > 0.99 * chosen


def test_a_search_and_a_fit_take_their_own_part_of_every_set(choosing):
    searched = SearchOptions.on("mujoco", generations=1, data=("real",), limit=6).source
    (fitted, real) = FitOptions("mujoco", data=("real",), limit=6).sources()
    assert (searched.part, searched.directory) == ("search", CHOOSING)
    assert (fitted.part, fitted.directory) == ("fitting", CHOOSING)
    assert (real.part, real.directory) == ("validation", "real")
    lists = {case.instance for case in load_cases(searched)}
    assert lists & set(choosing.select("search")["instance"])
    validation = load_benchmark("real").select("validation", limit=6)
    assert set(validation["instance"]) <= lists
    assert not lists & {case.instance for case in load_cases(fitted)}
    planar = SearchOptions.on("chipmunk", generations=1).source
    assert (planar.part, planar.directory) == ("validation", "planar")


def test_a_set_that_is_a_test_alone_is_refused():
    message = "lists: is split, and has no part fitting or validation; allowed: a set that has one"
    with pytest.raises(TuningError, match=message):
        FitOptions("mujoco", directory=LISTS).sources()
    with pytest.raises(TuningError, match="has no part search or validation"):
        SearchOptions.on("mujoco", benchmark=LISTS, generations=1)


def test_all_of_a_set_that_is_not_split_counts(tmp_path):
    benchmark = load_benchmark("planar")
    cases = benchmark.cases.drop(columns="instance").assign(split=None, rank=None)
    cases["split"] = cases["split"].astype(object)
    write_tables(tmp_path, benchmark.layouts.reset_index(), cases, benchmark.opinions, {})
    assert own_part(str(tmp_path), "fitting") == "train"
