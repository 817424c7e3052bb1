"""The authors' labelled set, made here in the form in which they publish it."""

import json

import pytest

from steadyload.labelling.building.authors import import_authors, read_authors
from steadyload.labelling.building.observations import RotationUnit, read_movements
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.writers import as_job

H1, H2 = "H1_Class_3_Instance_15_ULD_0", "H2_Class_3_Instance_15_ULD_0"


def layout(*offsets, shift=0.0, count=2):
    shifts = (*offsets, *([0.0] * (count - len(offsets))))
    items = (
        Item(k, (shift, 10.0 * k, 0.0), (10.0, 10.0, 10.0), 5.0, (offset, 0.0, 0.0), f"item-{k}")
        for k, offset in enumerate(shifts)
    )
    return Layout("any", Pallet(100.0, 500.0, 100.0), tuple(items))


def moves(*steps):
    """Raw observations: a step's shift along z [cm] and turn about x [degrees] of its last item."""
    content = []
    for step, (shift, angles) in enumerate(steps):
        place, turn = {"x": 3.0, "y": 7.0, "z": -1.0}, {"x": 0.0, "y": 0.0, "z": 0.0}
        still = {"translation": place, "rotation": turn}
        deltas = {
            str(item): {"itemLabel": f"i{item}", "observations": [{"time": 0.0} | still] * 3}
            for item in range(step)
        }
        samples = [
            {
                "time": 0.1 * n,
                "translation": {"x": 3.0, "y": 7.0, "z": -1.0 - along},
                "rotation": {"x": angle, "y": 0.0, "z": 0.0},
                "cm_velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
                "contacts": [],
            }
            for n, (along, angle) in enumerate(zip((0.0, 1.5 * shift, shift), angles, strict=True))
        ]
        deltas[str(step)] = {"itemLabel": f"i{step}", "observations": samples}
        content.append({"sequence": step, "itemDeltas": deltas})
    return content


STILL = (0.05, (0.0, 0.0, 0.1))


class Folder:
    """Writes files where the authors' scripts write them."""

    def __init__(self, root):
        self.root = root

    def put(self, name, content, *folders, dataset="Data_2"):
        path = self.root.joinpath("Data", dataset, *folders, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content))

    def job(self, name, what, scenario="1", *, score=None, raw=None, dataset="Data_2"):
        folder, file = (
            f"Ulds_scenario_{scenario}",
            f"{dataset}_Ulds_scenario_{scenario}_{name}.json",
        )
        content = as_job([what.renamed(file)]) if isinstance(what, Layout) else what
        self.put(file, content, "2_AeJobs", folder, dataset=dataset)
        if score is not None:
            self.put(file, {"score": score}, "4_Benchmark", folder, "done", dataset=dataset)
        if raw is not None:
            # Their simulation adds the ending again.
            place = ("4_Benchmark", folder, "done_raw")
            self.put(f"{file}.json", raw, *place, dataset=dataset)


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path / "download")


def heuristic(place):
    """H1 of the path of a file of H1."""
    name = place.split("/")[-1].split(".")[0]
    return name.removeprefix("Data_2_Ulds_scenario_1_").split("_")[0]


def imported(folder, tmp_path, **options):
    summary = import_authors(folder.root, tmp_path / "out", **options)
    return summary, load_benchmark(tmp_path / "out")


def test_scores_and_traces_of_a_stable_and_an_unstable_layout(folder, tmp_path):
    folder.job(H1, layout(), score=[1], raw=moves(STILL, STILL))
    falls = moves(STILL, (12.0, (0.0, 70.0, 40.0)))
    folder.job(H2, layout(shift=20.0), score=0.5, raw=falls)
    summary, benchmark = imported(folder, tmp_path)
    assert (summary.layouts, summary.cases, summary.labelled, summary.checked) == (2, 2, 2, 2)
    assert (summary.mismatches, summary.conflicts, summary.refused) == ((), (), ())
    cases = benchmark.cases.set_index("layout")
    assert cases["failing_step"].isna().tolist() == [True, False]
    assert cases.loc[H2, "failing_step"] == 1
    assert cases.loc[H2, "corner_last"].tolist() == pytest.approx([0.05, 12.0])
    assert cases.loc[H2, "corner_most"].tolist() == pytest.approx([0.075, 18.0])
    assert cases.loc[H2, "angle_last"].tolist() == pytest.approx([0.1, 40.0])
    assert cases.loc[H2, "angle_most"].tolist() == pytest.approx([0.1, 70.0])
    assert cases.loc[H2, "moved"].tolist() == [0, 1]
    empty = ["split", "rank", "failing_step_paper", "centre_last", "centre_most", "margin"]
    assert cases[empty].isna().all().all()
    assert benchmark.layouts.loc[H1, "instance"] == "Class_3_Instance_15"
    assert benchmark.layouts.loc[H1, "item_class"] == 3
    assert benchmark.manifest["origin"] == "imported"
    assert benchmark.manifest["source"] == "download"
    assert str(tmp_path) not in (tmp_path / "out" / "manifest.json").read_text()


def test_layouts_come_back_with_their_centres_of_mass(folder, tmp_path):
    folder.job(H1, layout(2.5, -1.25, shift=20.0), "2a", score=1)
    _, benchmark = imported(folder, tmp_path)
    back = benchmark.layout(H1, "S2a")
    assert back.content_hash() == layout(2.5, -1.25, shift=20.0).content_hash()


def test_a_case_is_kept_once_and_all_its_names(folder, tmp_path):
    folder.job(H2, layout(), score=1.0)
    folder.job("H10_Class_3_Instance_15_ULD_0", layout(), score=[1.0])
    folder.job(H1, layout(), score=1.0)
    summary, benchmark = imported(folder, tmp_path)
    assert (summary.layouts, summary.cases) == (1, 1)
    assert benchmark.layouts.index.tolist() == [H1]  # H2 before H10, H1 before both
    assert list(benchmark.layouts.loc[H1, "sources"]) == [H1, H2, "H10_Class_3_Instance_15_ULD_0"]


def test_one_geometry_with_other_centres_of_mass_is_another_case(folder, tmp_path):
    for name, offset in ((H1, 1.0), (H2, -1.0)):
        folder.job(name, layout(), "1", score=1.0)
        folder.job(name, layout(offset), "2b", score=1.0 if offset > 0 else 0.5)
    summary, benchmark = imported(folder, tmp_path)
    assert (summary.layouts, summary.cases, summary.conflicts) == (2, 3, ())
    keys = list(zip(benchmark.cases["layout"], benchmark.cases["scenario"], strict=True))
    assert keys == [(H1, "S1"), (H1, "S2b"), (H2, "S2b")]
    assert [list(s) for s in benchmark.layouts["sources"]] == [[H1, H2], [H2]]
    assert benchmark.layout(H2, "S2b").mass_offsets[0, 0] == -1.0
    assert benchmark.cases["failing_step"].tolist()[2] == 1


def test_weights_tell_cases_apart_and_a_geometry_has_one_instance(folder, tmp_path):
    heavy = Layout("heavy", layout().pallet, tuple(
        Item(i.sequence, i.position, i.size, 50.0) for i in layout().items))  # fmt: skip
    folder.job(H1, layout(), score=1.0)
    folder.job("H1_Class_3_Instance_30_ULD_0", heavy, score=1.0)
    summary, benchmark = imported(folder, tmp_path)
    assert summary.layouts == 2
    assert set(benchmark.layouts["instance"]) == {"Class_3_Instance_15"}


def test_one_name_for_two_geometries_gives_two_rows(folder, tmp_path):
    folder.job(H1, layout(), "1", score=1.0)
    folder.job(H1, layout(shift=20.0), "2a", score=1.0)
    _, benchmark = imported(folder, tmp_path)
    assert benchmark.layouts.index.tolist() == [H1, f"{H1}#2"]
    assert benchmark.layout(f"{H1}#2", "S2a").lower[0, 0] == 20.0


def test_conflicting_scores_are_counted_and_the_first_is_kept(folder, tmp_path):
    folder.job(H1, layout(), score=0.5)
    folder.job(H2, layout(), score=1.0)
    summary, benchmark = imported(folder, tmp_path)
    assert [heuristic(place) for place in summary.conflicts] == ["H2"]
    assert benchmark.cases["failing_step"].tolist() == [1]


def test_a_job_without_score_is_unlabelled_until_a_twin_has_one(folder, tmp_path):
    folder.job(H1, layout())
    folder.job(H1, layout(1.0), "2a")
    folder.job(H2, layout(), score=0.5)
    summary, benchmark = imported(folder, tmp_path)
    assert (summary.labelled, summary.unlabelled) == (1, 1)
    assert benchmark.cases["status"].tolist() == ["done", "unlabelled"]
    assert len(benchmark.select()) == 1


@pytest.mark.parametrize("name", ["3_AeResults", "5_Final_results"])
def test_labels_may_lie_in_another_folder(folder, tmp_path, name):
    folder.job(H1, layout())
    file = f"Data_2_Ulds_scenario_1_{H1}.json"
    folder.put(file, {"score": [0.5]}, name, "Ulds_scenario_1")
    assert imported(folder, tmp_path)[0].labelled == 1


def test_scores_of_other_methods_are_no_labels(folder, tmp_path):
    folder.job(H1, layout(), score=0.5)
    folder.job(H2, layout(shift=20.0))
    for name in (H1, H2):
        results = {"label": name, "score": 1.0, "assesmentEvaluationSet": [{"score": 1.0}]}
        place = ("3_AeResults", "Ulds_scenario_1")
        folder.put(f"Data_2_Ulds_scenario_1_{name}.json", results, *place)
    # A score by itself, where 4_Benchmark has one, too.
    folder.put(f"Data_2_Ulds_scenario_1_{H1}.json", {"score": 1.0}, "5_Final_results",
               "Ulds_scenario_1")  # fmt: skip
    summary, benchmark = imported(folder, tmp_path)
    assert (summary.labelled, summary.unlabelled) == (1, 1)
    assert benchmark.cases["failing_step"].tolist()[0] == 1


def test_damaged_files_are_named_and_do_not_hide_the_others(folder, tmp_path):
    folder.job(H1, layout(), score=1.0)
    folder.job("H3_Class_3_Instance_15_ULD_0", as_job([layout(shift=30.0)])[:-40], score=1.0)
    folder.job("H4_Class_3_Instance_15_ULD_0", layout(shift=40.0), score=0.7)
    folder.job("H5_Class_3_Instance_15_ULD_0", layout(shift=50.0), score=1.0, raw=moves(STILL))
    folder.job("H6_Class_3_Instance_15_ULD_0", layout(shift=60.0), score="NA")
    folder.put("stray.json", as_job([layout(shift=70.0)]), "2_AeJobs")
    summary, _ = imported(folder, tmp_path)
    assert (summary.labelled, summary.unlabelled) == (2, 2)
    refused = {heuristic(place): (place, reason) for place, reason in summary.refused}
    assert sorted(refused) == ["H3", "H4", "H5", "H6", "stray"]
    assert "cut off" in refused["H3"][1]
    assert refused["H4"][0].startswith("Data/Data_2/4_Benchmark/")
    assert "score is 0.7; allowed: k/2" in refused["H4"][1]
    assert "holds 1 steps; allowed: 0 to 1" in refused["H5"][1]
    assert "score is 'NA'" in refused["H6"][1]
    assert "lies in no folder of a scenario" in refused["stray"][1]
    assert all(str(tmp_path) not in place + reason for place, reason in summary.refused)


def test_the_rule_is_held_against_the_score(folder, tmp_path):
    folder.job(H1, layout(), score=1.0, raw=moves(STILL, (11.0, (0.0, 0.0, 0.0))))
    folder.job(H2, layout(shift=20.0), score=0.5, raw=moves(STILL, (10.0, (0.0, 12.0, 10.0))))
    folder.job("H3_Class_3_Instance_15_ULD_0", layout(shift=40.0), score=0.5,
               raw=moves(STILL, (0.0, (0.0, 0.0, 10.5))))  # fmt: skip
    summary, benchmark = imported(folder, tmp_path)
    assert [heuristic(place) for place in summary.mismatches] == ["H1", "H2"]
    assert summary.checked == 3
    assert benchmark.cases["failing_step"].isna().tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("angles", "turned"),
    [
        ((359.0, 0.0, 1.0), 2.0),
        ((1.0, 0.0, 359.0), 2.0),
        ((-179.0, 180.0, 179.0), 2.0),
        ((90.0, 90.0, 75.0), 15.0),
    ],
)
def test_angles_are_relative_and_wrap_around(angles, turned):
    found = read_movements(moves(STILL, (0.0, angles)), 2)
    assert found.angle_last[1] == pytest.approx(turned)
    assert found.failing_step == (1 if turned > 10.0 else None)


def test_axes_are_looked_at_one_by_one():
    content = moves(STILL, (7.0, (0.0, 0.0, 7.0)))
    last = content[1]["itemDeltas"]["1"]["observations"][-1]
    last["translation"]["y"] += 7.0
    last["rotation"]["z"] = -7.0
    found = read_movements(content, 2)
    assert (found.corner_last[1], found.angle_last[1]) == (7.0, 7.0)
    assert found.failing_step is None


def test_radians_are_an_option_and_a_wrong_unit_is_suspected(folder, tmp_path):
    folder.job(H1, layout(), score=0.5, raw=moves(STILL, (30.0, (0.0, 1.0, 1.5))))
    summary, _ = imported(folder, tmp_path)
    assert "radians" in summary.doubts[0]
    summary, benchmark = imported(folder, tmp_path, rotation_unit=RotationUnit.RADIANS)
    assert summary.doubts == ()
    assert benchmark.cases["angle_last"][0][1] == pytest.approx(85.94, abs=0.01)
    folder.job(H2, layout(shift=20.0), score=0.5, raw=moves(STILL, (30.0, (0.0, 80.0, 80.0))))
    assert "degrees" in imported(folder, tmp_path, rotation_unit=RotationUnit.RADIANS)[0].doubts[0]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "holds 0 steps"),
        ({"sequence": 0}, "is no list of steps"),
        ([{"sequence": 0, "itemDeltas": {}}], "holds no items"),
        ([{"sequence": 0, "itemDeltas": {"1": {"observations": []}}}], "item is '1'"),
        ([{"sequence": 0, "itemDeltas": {"0": {"observations": []}}}], "step 0, item 0"),
        (moves(STILL) * 2, "stands there twice"),
        (moves((float("nan"), (0.0, 0.0, 0.0))), "finite"),
    ],
    ids=["empty", "no-list", "no-items", "unknown-item", "no-samples", "twice", "nan"],
)
def test_observations_of_another_form_are_refused(content, message):
    with pytest.raises(BenchmarkError, match=message):
        read_movements(content, 1)


def test_layouts_are_cut_to_what_was_simulated(folder, tmp_path):
    folder.job(H1, layout(count=25), score=0.95)
    summary, benchmark = imported(folder, tmp_path)
    assert summary.refused == ()
    assert (benchmark.cases["item_count"][0], benchmark.cases["failing_step"][0]) == (20, 19)


def test_the_first_data_set_has_its_flights_as_instances(folder, tmp_path):
    for device in ("pmc_F_ld-14", "ake-3"):
        shift = 5.0 * len(device)
        folder.job(f"LH8044-28NOV15-FRA-ORD_{device}", layout(shift=shift), score=1.0,
                   dataset="Data_1")  # fmt: skip
    folder.job(H1, layout(), score=1.0)
    _, benchmark = imported(folder, tmp_path)
    assert benchmark.layouts["instance"].tolist() == ["LH8044-28NOV15-FRA-ORD"] * 2 + [
        "Class_3_Instance_15"
    ]
    assert benchmark.layouts["item_class"].tolist() == [0, 0, 3]


@pytest.mark.parametrize("place", [".", "Data", "Data/Data_2"])
def test_any_of_three_folders_may_be_named(folder, place):
    folder.job(H1, layout(), score=1.0)
    assert read_authors(folder.root / place)[2].labelled == 1


def test_a_folder_of_something_else_is_refused_and_nothing_written(folder, tmp_path):
    out = tmp_path / "out"
    folder.root.mkdir()
    for source in (folder.root, tmp_path / "missing"):
        with pytest.raises(BenchmarkError, match=source.name):
            import_authors(source, out)
    folder.job(H1, "{")
    with pytest.raises(BenchmarkError, match="no readable job file"):
        import_authors(folder.root, out)
    assert not out.exists()


def test_only_a_labelled_set_is_replaced(folder, tmp_path):
    folder.job(H1, layout(), score=1.0)
    imported(folder, tmp_path)
    imported(folder, tmp_path)  # again, over it
    (tmp_path / "study").mkdir()
    (tmp_path / "study" / "manifest.json").write_text("{}")
    for foreign in (tmp_path / "study", folder.root):
        with pytest.raises(BenchmarkError, match="no labelled set to replace"):
            import_authors(folder.root, foreign)
    assert (tmp_path / "study" / "manifest.json").read_text() == "{}"


def test_progress_counts_job_files(folder, tmp_path):
    seen = []
    folder.job(H1, layout(), score=1.0)
    folder.job(H2, "{")
    imported(folder, tmp_path, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 2), (2, 2)]
