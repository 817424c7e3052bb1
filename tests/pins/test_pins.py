"""The comparison of pinned pages sees what became of a number."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

PAGE = """# A page

It has 3 methods.

## Accuracy

**Scenario S1**

| method | n | accuracy % |
| ------ | --: | --: |
| SME | 30 | 81.0 [76.2, 85.0] |
| FBS | 30 | 45.0 [40.0, 50.0] |

**Scenario S2a**

| method | n | accuracy % |
| ------ | --: | --: |
| SME | 31 | 82.0 [77.2, 86.0] |

![A figure.](figures/accuracy.png)
"""


@pytest.fixture
def pins(monkeypatch: pytest.MonkeyPatch) -> tuple[ModuleType, ModuleType]:
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("facts"), importlib.import_module("differences")


def _found(pins, now, entries=None):
    facts, differences = pins
    return differences.compare_pages(
        "toy", facts.read_page(PAGE), facts.read_page(now), differences.Renames(entries or {})
    )


def test_an_unchanged_page_has_all_facts(pins):
    found = _found(pins, PAGE)
    assert found.clean
    assert found.same == 8  # six cells, a sentence, a figure
    assert not found.new


def test_a_changed_number_is_told(pins):
    found = _found(pins, PAGE.replace("82.0 [", "82.1 ["))
    assert found.changed == [
        "Accuracy / Scenario S2a | SME | accuracy %: 82.0 [77.2, 86.0] -> 82.1 [77.2, 86.0]"
    ]
    assert not found.missing


def test_a_dropped_row_is_told(pins):
    found = _found(pins, PAGE.replace("| FBS | 30 | 45.0 [40.0, 50.0] |\n", ""))
    assert found.missing == [
        "Accuracy / Scenario S1 | FBS | n: 30",
        "Accuracy / Scenario S1 | FBS | accuracy %: 45.0 [40.0, 50.0]",
    ]


def test_a_moved_and_merged_table_is_found(pins):
    merged = """# A page

It has 3 methods.

## How good methods are

| scenario | method | accuracy % | n |
| --- | --- | --: | --: |
| S2a | SME | 82.0 [77.2, 86.0] | 31 |
| S1 | SME | 81.0 [76.2, 85.0] | 30 |
| S1 | FBS | 45.0 [40.0, 50.0] | 30 |

![A figure.](figures/accuracy.png)
"""
    found = _found(pins, merged)
    assert found.clean
    assert len(found.moved) == 6
    swapped = merged.replace("S2a |", "S? |").replace("S1 | SME", "S2a | SME")
    assert not _found(pins, swapped.replace("S? |", "S1 |")).clean


def test_a_changed_sentence_is_missing_and_one_with_the_same_numbers_is_not(pins):
    assert _found(pins, PAGE.replace("It has 3 methods.", "It has 4 methods.")).missing
    assert _found(pins, PAGE.replace("It has 3", "There are 3")).reworded


def test_declared_changes_are_allowed(pins):
    renamed = PAGE.replace("accuracy %", "right %")
    assert not _found(pins, renamed).clean
    assert _found(pins, renamed, {"column": [{"old": "accuracy %", "new": "right %"}]}).clean
    waived = {"waived": [{"column": "accuracy %", "reason": "said in another table"}]}
    assert _found(pins, renamed, waived).clean
