"""The study of transport: limits are kept, distances are those of a count by hand."""

import pandas as pd
import pytest

from steadyload.app.recommend.front import front_for
from steadyload.app.recommend.kept import load_fronts
from steadyload.layouts.benchmark.parts import LISTS, REAL
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.model.question import Question
from steadyload.reports.table import decimal, plain_percent
from steadyload.studies.kit import Lab
from steadyload.studies.transport import limits_of_loads as module
from steadyload.studies.transport.comparing import Loads, compare
from steadyload.studies.transport.limits_of_loads import (
    REFERENCE,
    RISING,
    RUBBING,
    WHOLE,
    Load,
    LoadLimits,
    engines_on_the_front,
    limits_of_loads,
    standing_loads,
)
from steadyload.studies.transport.study import Transport
from steadyload.transport.errors import TransportError
from steadyload.transport.limits import EXACT, limits
from steadyload.transport.whole_load import whole_load_limit

PALLET = Pallet(120.0, 200.0, 80.0)


@pytest.mark.parametrize("direction", [0.0, 30.0, 90.0, 200.0])
def test_the_whole_of_a_single_box_is_the_box(direction):
    offset = (3.0, -4.0, 2.0)
    box = Item(0, (40.0, 0.0, 30.0), (20.0, 60.0, 30.0), 8.0, offset)
    layout = Layout("one", PALLET, (box,))
    (exact,) = limits(layout, directions=(direction,))
    assert whole_load_limit(layout, 0.5, direction) == pytest.approx(exact.limit_g, abs=1e-6)
    assert whole_load_limit(layout, 0.01, direction) == pytest.approx(0.01)


def test_a_load_whose_centre_of_mass_is_past_its_base_holds_nothing():
    foot = Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0)
    top = Item(1, (0.0, 10.0, 0.0), (60.0, 10.0, 10.0), 50.0)
    assert whole_load_limit(Layout("past", PALLET, (foot, top)), 0.5, 0.0) == 0.0


def test_a_load_above_the_deck_is_refused():
    box = Item(0, (0.0, 2.0, 0.0), (10.0, 10.0, 10.0), 1.0)
    with pytest.raises(TransportError, match=r"'high': its lowest box is 2 cm above the deck"):
        whole_load_limit(Layout("high", PALLET, (box,)), 0.5, 0.0)


def test_loads_stand_by_their_label_and_are_different_first():
    loads = standing_loads(LISTS, 50)
    assert len({load.name.rpartition(" ")[0] for load in loads}) == len(loads) == 50
    (found,) = limits(loads[0].layout, "label@mujoco", directions=(0.0,))
    assert found.limit_g is not None


def test_loads_of_real_size_have_few_boxes():
    every, few = standing_loads(REAL, 1000), standing_loads(REAL, 1000, 40)
    assert [load.name for load in few] == [one.name for one in every if len(one.layout) <= 40]
    assert 0 < len(few) < len(every)


def test_loads_of_real_size_are_asked_of_engines_that_no_cheaper_one_beats():
    found = engines_on_the_front(61)
    here = front_for(load_fronts(), Question.STANDS, 61).here()
    rows = {m.engine: m for m in here.measured if m.method.startswith("ps_opt@")}
    cpu = [rows[name].cpu.value for name in found]
    assert found
    assert cpu == sorted(cpu)
    for name, row in rows.items():
        cheaper = [rows[own] for own in found if rows[own].cpu.value < row.cpu.value]
        beaten = any(one.accuracy.value >= row.accuracy.value for one in cheaper)
        assert beaten is (name not in found)


def test_limits_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "fixed_step_engines", lambda *_: ("mujoco",))
    monkeypatch.setattr(module, "REFERENCED", 0)
    monkeypatch.setattr(module, "DIRECTIONS", 1)
    found = limits_of_loads(Lab(tmp_path, 0), 1)
    assert {of: len(own) for of, own in found.loads.items()} == {LISTS: 1, REAL: 0}
    shards = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "limits").iterdir()}
    again = limits_of_loads(Lab(tmp_path, 0), 1)
    assert found.rows.drop(columns="cpu_ms").equals(again.rows.drop(columns="cpu_ms"))
    assert {p.name: p.stat().st_mtime_ns for p in (tmp_path / "limits").iterdir()} == shards
    assert {EXACT, RUBBING, WHOLE, REFERENCE, "label@mujoco"} <= set(found.rows["method"])
    assert set(found.rows["rise"]) == {0.0, 0.05, 0.2, 0.5}


def made_up():
    """Two loads of each set in two directions; the second one leans."""
    layout = Layout("x", PALLET, (Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),))
    loads = {
        of: [Load(of, f"{of}-{k}", layout, f"list-{k}") for k in range(2)] for of in (LISTS, REAL)
    }
    rows = []

    def add(of, load, method, values, mode="tips", rise=0.0):
        for direction, value in zip((0.0, 180.0), values, strict=True):
            rows.append(
                {"of": of, "load": load, "item_list": f"list-{load}", "method": method,
                 "rise": rise, "direction_deg": direction, "limit_g": value, "moved_item": 0,
                 "displacement_cm": None, "mode": mode, "reason": "", "cpu_ms": 2.0}
            )  # fmt: skip

    for of in (LISTS, REAL):
        add(of, 0, EXACT, (0.30, 0.40))
        add(of, 1, EXACT, (0.0, 0.0), mode="falls")
        for mu in (0.2, 0.3, 0.4, 0.6):
            add(of, 0, f"{EXACT},friction={mu:g}", (mu / 2, mu))
        for load in range(2):
            add(of, load, REFERENCE, (0.25, 0.41))
            add(of, load, RISING, (0.26, None))
            add(of, load, WHOLE, (0.5, 0.5), mode=None)
    for rise in (0.05, 0.2, 0.5):
        add(LISTS, 0, RISING, (0.26 - rise / 10, None), rise=rise)
    return LoadLimits(loads, pd.DataFrame(rows))


@pytest.fixture(scope="module")
def found():
    return compare(made_up(), {"source": "here"})


def test_distances_are_those_of_a_count_by_hand(found):
    assert found.small_loads == found.real_loads == Loads(2, 1, 2, 1, 1)
    small, leaning, real, real_leaning = found.distances.values()
    assert list(small.index) == [EXACT, WHOLE, RISING]
    exact, engine = small.loc[EXACT], small.loc[RISING]
    assert (exact.limit_apart.n, exact.limits, exact.loads) == (2, 2, 1)
    assert exact.limit_apart.value == pytest.approx(0.02)
    assert (exact.clearly_above.value, exact.clearly_below.value) == (0.5, 0.0)
    assert pd.isna(small["direction_cpu"][WHOLE])
    assert (engine.limit_apart.n, engine.clearly_above.value) == (1, 0.0)
    assert list(leaning.index) == [WHOLE, RISING]
    assert real["limits"].to_dict() == {EXACT: 2, WHOLE: 2, RISING: 1}
    assert real_leaning["limits"].to_dict() == {WHOLE: 2, RISING: 1}
    of_exact = found.weakest
    assert (of_exact.of_loads, of_exact.title) == ("real size", "Equilibrium")
    assert of_exact.weakest.value == pytest.approx(0.30)
    assert [of_exact[f"held:{level}"].value for level in (0.2, 0.3, 0.5)] == [1.0, 1.0, 0.0]
    assert [more.value for _, more in found.rises] == pytest.approx([-0.005, -0.02, -0.05])
    assert found.without[RISING] == 7
    assert [one.weakest for one in found.drawn] == pytest.approx([0.30])


def test_the_page_shows_what_was_found(found, assert_shown):
    weakest = found.weakest
    assert_shown(
        Transport(),
        found,
        answer=[
            decimal(weakest.weakest, 3),
            *(
                plain_percent(one.clearly_above.value)
                for one in (found.by_equilibrium, found.by_thumb)
            ),
        ],
        charts=["around", "differences", "weakest"],
    )
