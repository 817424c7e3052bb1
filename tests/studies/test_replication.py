"""The paper's experiment: its files, labels and splits, each checked by hand."""

import dataclasses
import itertools

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.building.paper_files import FileOptions, make_files
from steadyload.labelling.label_rows import LABEL
from steadyload.labelling.paper_labels import (
    content_of,
    label_files,
    label_units,
    labelled_cases,
    ship_labels,
    shipped_labels,
)
from steadyload.layouts.packing.heuristics import Heuristic
from steadyload.layouts.packing.packing import HEURISTICS, make_instance, pack_instance
from steadyload.methods.registry import make_method
from steadyload.studies.replication.splits import (
    TABLE_2,
    TEST,
    VALIDATION,
    SplitError,
    SplitKind,
    draw_parts,
    folds,
    with_twin,
)

# First fit and worst fit by two space rules: they agree until a second bin is opened.
FEW = tuple(map(Heuristic.numbered, (1, 2, 41, 42)))
TINY = FileOptions(seed=5, lists=3, item_counts={1: 5, 2: 5, 3: 7}, heuristics=FEW)


@pytest.fixture(scope="module")
def files():
    return make_files(TINY)


@pytest.fixture(scope="module")
def labels(files):
    """A made-up label for every distinct case: unstable at a step drawn by its content."""
    made = {}
    for scenario, rows in files.in_turns():
        for row in rows:
            layout = files.case(row, scenario)
            content = content_of(layout)
            made[content] = content % len(layout) if content % 3 == 0 else None
    return made


@pytest.fixture(scope="module")
def cases(files, labels):
    made = labelled_cases(files, labels)
    return made.assign(part=draw_parts(made, seed=1, sizes=SIZES))


SIZES = {name: {TEST: (6, 3), VALIDATION: (2, 1)} for name in TABLE_2}


# files


def test_there_is_a_file_a_heuristic_list_and_bin(files):
    expected = {
        layout.name: layout.geometry_hash()
        for which, number, heuristic in itertools.product(range(3), (1, 2, 3), FEW)
        for layout in pack_instance(
            make_instance(number, which, seed=5, item_count=TINY.item_counts[number]), heuristic
        )
    }
    table = files.table
    assert sorted(table["file"]) == sorted(expected)
    hashes = [files.geometries[name].geometry_hash() for name in table["geometry"]]
    assert hashes == [expected[name] for name in table["file"]]
    assert len(set(expected.values())) == len(files.geometries) < len(table)


def test_the_package_has_the_files_and_geometries_that_are_stated():
    options = FileOptions()
    assert (options.seed, options.lists, len(options.heuristics)) == (1, 4, 160)
    assert options.heuristics == HEURISTICS


def test_twins_are_one_case_in_s1_and_several_in_s2(files):
    table = files.table
    twins = table[table["geometry"] == table["geometry"].value_counts().index[0]].index
    assert len(twins) > 1
    contents = {s: [content_of(files.case(row, s)) for row in twins] for s in ("S1", "S2a", "S2b")}
    assert len(set(contents["S1"])) == 1
    assert len(set(contents["S2a"])) == len(set(contents["S2b"])) == len(twins)
    assert {files.case(row, "S2b").geometry_hash() for row in twins} == {
        files.case(row, "S1").geometry_hash() for row in twins
    }


def test_shifts_keep_to_their_law(files):
    shares = {
        scenario: np.concatenate(
            [
                (lay.mass_offsets / (lay.upper - lay.lower)).ravel()
                for row in files.table.index
                if (lay := files.case(row, scenario))
            ]
        )
        for scenario in ("S2a", "S2b")
    }
    for scenario, spread in (("S2a", 0.8 / 6.0), ("S2b", 0.8 / 12.0**0.5)):
        # Centres of mass are rounded to 0.01 cm, which is a share of 0.01 of the smallest side.
        assert np.abs(shares[scenario]).max() <= 0.405
        assert shares[scenario].std() == pytest.approx(spread, rel=0.1)
        assert abs(shares[scenario].mean()) < 0.02


def test_files_are_remade_exactly(files):
    again = make_files(TINY)
    row = files.table.index[-1]
    assert again.table.equals(files.table)
    assert again.case(row, "S2a").content_hash() == files.case(row, "S2a").content_hash()


def test_turns_hold_every_case_once_and_every_third_file_first(files):
    turns = list(files.in_turns())
    assert [scenario for scenario, _ in turns] == ["S1", "S2a", "S2b"] * 2
    for scenario in ("S1", "S2a", "S2b"):
        contents = [
            content_of(files.case(row, s)) for s, rows in turns if s == scenario for row in rows
        ]
        everything = {content_of(files.case(row, scenario)) for row in files.table.index}
        assert len(contents) == len(set(contents))
        assert set(contents) == everything
    for scenario, rows in turns[:3]:
        assert set(rows) <= set(files.table.index[::3]), scenario


def test_some_files_are_evenly_drawn(files):
    every = list(files.table.index)
    assert list(files.some(len(every) // 2).table.index) == every[: len(every) // 2 * 2 : 2]
    assert list(files.some(len(every) + 1).table.index) == every


# labels


def test_labels_are_those_of_the_reference_and_a_run_goes_on(files, tmp_path):
    small = dataclasses.replace(files, table=files.table[files.table["item_count"] <= 2])
    units = list(label_units(small))
    known = {content_of(lay): None for _, _, lay in units[0].judgements}
    found = label_files(small, tmp_path, known=known, workers=0)
    written = sorted((tmp_path / "labels").iterdir())
    # What is known is not labelled again, whatever it says.
    assert len(written) == len(units) - 1
    assert sum(map(len, units)) == len(found)
    method = make_method(LABEL)
    for _, _, layout in units[1].judgements[:3]:
        assert found[content_of(layout)] == method.judge(layout).failing_step
    again = label_files(small, tmp_path, known=known, workers=0)
    assert again == found
    assert sorted((tmp_path / "labels").iterdir()) == written


def test_shipped_labels_come_back(tmp_path):
    labels = {2**59: None, 5: 0, 7: 19}
    ship_labels(labels, tmp_path / "labels.parquet")
    assert shipped_labels(tmp_path / "labels.parquet") == labels
    assert shipped_labels(tmp_path / "none.parquet") == {}


# splits


def test_cases_have_a_row_a_file_and_scenario(files, labels, cases):
    assert len(cases) == 3 * len(files.table)
    for row in cases.itertuples():
        layout = files.case(row.row, row.scenario)
        step = labels[content_of(layout)]
        assert (row.name, row.item_count) == (layout.name, len(layout))
        assert (None if row.failing_step is pd.NA else row.failing_step) == step
    s1 = cases[cases["scenario"] == "S1"]
    assert (s1.groupby("geometry")["failing_step"].nunique(dropna=False) == 1).all()


def test_files_without_a_label_are_left_out(files, labels, cases):
    gone = int(cases[cases["scenario"] == "S2b"]["content"].iloc[0])
    fewer = labelled_cases(files, {k: v for k, v in labels.items() if k != gone})
    assert len(fewer) == len(cases) - 1


def test_parts_have_the_sizes_of_table_2(cases):
    for (scenario, stable), own in cases.groupby(["scenario", cases["failing_step"].isna()]):
        size = SIZES[scenario]
        found = own["part"].value_counts()
        assert found[TEST] == size[TEST][0 if stable else 1]
        assert found[VALIDATION] == size[VALIDATION][0 if stable else 1]
    printed = {"S1": (44, 44), "S2a": (50, 49), "S2b": (56, 57)}
    assert {name: size[VALIDATION] for name, size in TABLE_2.items()} == printed
    assert {size[TEST] for size in TABLE_2.values()} == {(150, 150)}


def test_too_few_files_are_an_error(cases):
    few = {TEST: (1, 150), VALIDATION: (0, 44)}
    with pytest.raises(SplitError, match=r"S1: \d+ labelled unstable files; needed: 194"):
        draw_parts(cases, seed=0, sizes=dict.fromkeys(TABLE_2, few))


def test_every_split_tests_the_same_files(cases):
    for kind in SplitKind:
        tested = np.sum([fold.test for fold in folds(cases, kind)], axis=0)
        assert tested.tolist() == (cases["part"] == TEST).astype(int).tolist()


@pytest.mark.parametrize("kind", SplitKind)
def test_nothing_held_out_is_learnt_from(cases, kind):
    for fold in folds(cases, kind):
        held = fold.test | fold.validation
        assert fold.train.any()
        assert not (fold.train & (cases["part"] != "").to_numpy()).any()
        keys = [cases["file"], cases["scenario"]]
        names = pd.MultiIndex.from_arrays(keys)
        assert not set(names[fold.train]) & set(names[held])
        if kind in (SplitKind.GEOMETRY, SplitKind.LIST):
            assert not set(cases["geometry"][fold.train]) & set(cases["geometry"][held])
            assert not with_twin(cases, [fold]).any()
        if kind is SplitKind.LIST:
            others = fold.train | fold.validation
            assert not set(cases["instance"][others]) & set(cases["instance"][fold.test])


def test_by_file_twins_stay_and_fewer_are_as_many_as_by_geometry(cases):
    file, fewer, geometry = (
        folds(cases, kind)[0] for kind in (SplitKind.FILE, SplitKind.FEWER, SplitKind.GEOMETRY)
    )
    assert file.train.sum() == (cases["part"] == "").sum()
    assert fewer.train.sum() == geometry.train.sum() < file.train.sum()
    assert not (fewer.train & ~file.train).any()
    twins = with_twin(cases, [file])[file.test]
    expected = [
        any((cases["geometry"] == row.geometry) & (cases["scenario"] == row.scenario) & file.train)
        for row in cases[file.test].itertuples()
    ]
    assert twins.tolist() == expected
    assert any(expected)
