"""The method that docs/architecture.md shows is one: registered, judged, put to properties."""

import re
from pathlib import Path

import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods.registry import METHODS, make_method, method_listing
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search

TEXT = (Path(__file__).parents[2] / "docs" / "architecture.md").read_text()
SECTION = TEXT.partition("## A method of forty lines")[2].partition("\n## ")[0]


@pytest.fixture
def carried_centre(tmp_path, monkeypatch):
    """Its name, once it is registered as the page says, but for where the file lies."""
    code = re.search(r"```python\n(.*?)```", SECTION, re.DOTALL)[1]
    name, target = re.search(r'`"(\w+)": "steadyload\.methods\.([\w:]+)",`', SECTION).groups()
    assert f"harness/methods/{target.partition(':')[0]}.py" in SECTION
    (tmp_path / f"{target.partition(':')[0]}.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(METHODS, name, target)
    return name


def test_it_is_listed_with_its_parameter(carried_centre):
    [listed] = [method for method in method_listing() if method.name == carried_centre]
    assert [(p.name, p.unit) for p in listed.parameters] == [("margin", "cm")]


@pytest.mark.parametrize(
    ("shift", "margin", "failing"), [(4.9, 0, None), (5.1, 0, 1), (4.5, 0.4, None), (4.5, 0.6, 1)]
)
def test_a_cube_falls_whose_centre_is_too_near_an_edge(
    carried_centre, stack, shift, margin, failing
):
    verdict = make_method(f"{carried_centre}:margin={margin}").judge(stack(0.0, shift))
    assert verdict.failing_step == failing


def carried(item, others):
    """Whether a vertical line through the centre of mass meets the floor or another's top."""
    x, _, z = (
        p + s / 2 + o for p, s, o in zip(item.position, item.size, item.mass_offset, strict=True)
    )
    return item.position[1] < 1e-6 or any(
        abs(other.position[1] + other.size[1] - item.position[1]) < 1e-6
        and other.position[0] <= x <= other.position[0] + other.size[0]
        and other.position[2] <= z <= other.position[2] + other.size[2]
        for other in others
    )


def test_it_names_the_first_box_of_labelled_cases_with_nothing_under_its_centre(carried_centre):
    labelled, method = load_benchmark(), make_method(carried_centre)
    cases = labelled.select("validation", limit=100)[["layout", "scenario"]].to_numpy()
    failing = []
    for layout in (labelled.layout(*case) for case in cases):
        hang = [not carried(item, layout.items[:k]) for k, item in enumerate(layout.items)]
        failing.append(hang.index(True) if any(hang) else None)
        assert method.judge(layout).failing_step == failing[-1]
    assert len(set(failing)) > 5


def test_it_has_the_traits_that_it_declares(carried_centre):
    tested = MethodUnderTest(carried_centre)
    asked = {name: one for name, one in PROPERTIES.items() if one.applies(tested)}
    assert len(asked) > 3
    for one in asked.values():
        outcome = search(one, tested, examples=8, seed=1)
        assert outcome.counterexample is None, outcome.counterexample
        assert outcome.asked > 0
