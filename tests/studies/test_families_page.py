"""The study of families: its figures are those counted by hand from the kept rows."""

import dataclasses

import pandas as pd
import pytest

from steadyload.layouts.packing import families as packing
from steadyload.reports.table import percent, plain_percent
from steadyload.runs.judged import load_judged
from steadyload.runs.results import ResultsError, load_results
from steadyload.statistics.metrics import share
from steadyload.studies.families import comparing, judging
from steadyload.studies.families.comparing import ALL, Found, compare
from steadyload.studies.families.study import Families
from steadyload.studies.kit import Lab

LABEL, AGAINST = "label@mujoco", "equilibrium:time=0.3"
NAMES = ("cartons", "off-centre")
LAYOUTS = 3


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Two families, labelled by an engine that is quicker than the reference."""
    with pytest.MonkeyPatch.context() as patch:
        few = {name: packing.FAMILIES[name] for name in NAMES}
        for module in (packing, judging, comparing):
            patch.setattr(module, "FAMILIES", few)
        for module in (judging, comparing):
            patch.setattr(module, "LABEL", LABEL)
            patch.setattr(module, "SEED", 5)
        work = tmp_path_factory.mktemp("families")
        asked = Families(limit=LAYOUTS, methods=("fbs", "lstm_e", "ps_opt@mujoco"))
        yield asked, work, asked.run(Lab(work, workers=0))


@pytest.fixture(scope="module")
def counted(result):
    """By family, method and layout: the failing step, all boxes for none, or None if refused."""
    rows = load_results(result[1] / "run")
    rows["said"] = rows["failing_step"].fillna(rows["item_count"]).astype(float)
    rows["said"] = rows["said"].where(rows["status"] == "done")
    rows["family"] = rows["layout"].str.rsplit("-", n=1).str[0]
    return rows


@pytest.mark.parametrize("family", [*NAMES, ALL])
def test_the_shares_of_every_method_are_those_counted_by_hand(result, counted, family):
    _, _, found = result
    rows = counted if family == ALL else counted[counted["family"] == family]
    said = rows.pivot(index="layout", columns="method", values="said")
    n = LAYOUTS * (len(NAMES) if family == ALL else 1)
    shown = found.methods if family == ALL else found.each[family]
    assert set(shown.index) == set(said.columns) - {LABEL}
    for own in shown.itertuples():
        mine, label = said[own.Index], said[LABEL]
        assert own.right.n == len(said) == n
        assert own.over.value == pytest.approx((mine > label).mean())
        assert own.under.value == pytest.approx((mine < label).mean())
        assert own.refused.value == pytest.approx(mine.isna().mean())
        assert pd.isna(own.lost)
        assert own.right == share(mine == label)  # Wilson's, of independent layouts
        ended = own.right.value + own.over.value + own.under.value + own.refused.value
        assert ended == pytest.approx(1.0)
    about = found.families.loc[family]
    items = rows.drop_duplicates("layout").set_index("layout")["item_count"]
    assert about["stable"].value == pytest.approx((said[LABEL] == items).mean())
    cpu = 1e3 * rows[rows["method"] == LABEL]["cpu_total"]
    assert about["label_cpu"].value == pytest.approx(cpu.mean())


def test_a_network_refuses_what_lies_outside_of_what_it_was_trained_on(result):
    _, _, found = result
    assert found.each["off-centre"]["refused"]["lstm_e"].value > 0.5
    assert found.refusing.name == "lstm_e"


def test_methods_are_compared_on_the_same_layouts(result, counted):
    _, _, found = result
    said = counted.pivot(index="layout", columns="method", values="said")
    right = said.eq(said[LABEL], axis=0)
    assert found.against.spec == AGAINST
    assert set(found.gains.index) == set(said.columns) - {LABEL, AGAINST}
    for own in found.gains_by_family.itertuples():
        mine, other = right[own.Index], right[AGAINST]
        assert own.difference.value == pytest.approx(mine.mean() - other.mean())
        assert own.only_it.value == pytest.approx((mine & ~other).mean())
        assert own.only_other.value == pytest.approx((other & ~mine).mean())
        for name in NAMES:
            here = right.index.str.startswith(name)
            by_hand = mine[here].mean() - other[here].mean()
            gain = found.gains_by_family[f"family_gain:{name}"][own.Index]
            assert gain.value == pytest.approx(by_hand)
    assert found.simulations == 1
    assert found.more == found.fewer == []  # six layouts show nothing


def test_a_layout_without_a_label_is_counted_apart(result, counted, monkeypatch):
    _, work, whole = result
    judged = load_judged(work / "run")
    lost = judged.said.index[0]
    said = judged.said.copy()
    said.loc[lost, LABEL] = None
    results = judged.results.copy()
    here = (results["layout"] == lost[0]) & (results["method"] == LABEL)
    results.loc[here, "status"] = "error"
    families = {name: name.rsplit("-", 1)[0] for name in judged.said.index.unique("layout")}
    changed = dataclasses.replace(judged, said=said, results=results)
    found = compare(judging.FamilyCases(changed, families, {}, LAYOUTS))
    count = len(whole.each) * LAYOUTS - 1
    assert found.families["stable"][ALL].n == count
    assert found.families["unlabelled"][ALL] == {"error": 1}
    assert {own.n for own in found.methods["right"]} == {count}
    said[LABEL] = None
    none = dataclasses.replace(judged, said=said)
    with pytest.raises(ResultsError, match="label@mujoco has a verdict on none of the cases"):
        compare(judging.FamilyCases(none, families, {}, LAYOUTS))


def test_more_layouts_go_on_from_fewer(result):
    _, work, found = result
    judged = load_judged(work / "run")
    names = judged.said.index.get_level_values("layout")
    assert set(names) == {f"{name}-{k:04d}" for name in NAMES for k in range(LAYOUTS)}
    texts = (work / "families.layouts").read_text()
    places = [texts.index(f'"{name}-{k:04d}"') for k in range(LAYOUTS) for name in NAMES]
    assert places == sorted(places)
    assert found.boxes[0] >= packing.FEWEST


def test_the_page_shows_what_was_found(result, assert_shown):
    asked, _, found = result
    told = Found(**vars(found) | {"left_out": {"ps_opt@none": "engine 'none' is not installed"}})
    text = assert_shown(
        asked,
        told,
        answer=[found.best["right"].n, percent(found.best["right"])],
        charts=["right"],
        drawn=False,
    )
    assert plain_percent(found.refusing["refused"].value) in text
    assert "ps_opt@none" in text
