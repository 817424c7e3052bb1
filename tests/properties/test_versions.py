"""What a property asks changes only with its version, since results are kept by that."""

import hashlib
import json
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import pytest
from hypothesis.internal.cache import LRUCache
from hypothesis.internal.conjecture import providers
from hypothesis.internal.conjecture.providers import HypothesisProvider
from hypothesis.internal.constants_ast import Constants

from steadyload.layouts.writers import as_native
from steadyload.properties.property import Case, MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.properties.strategies import towers

FILE = Path(__file__).with_name("cases_by_version.json")
"""Digests of drawn cases by property and version, and the version of hypothesis that drew them."""

METHODS = ("label@mujoco", "pbs")
"""The cases of a property are drawn for the first of these methods that it applies to."""


def digest(asked):
    """Of the first cases that a property asks about: their layouts, and what else is drawn.

    Without the constants of loaded modules, of which hypothesis draws a share of all values.
    """
    tested = next(t for t in map(MethodUnderTest, METHODS) if asked.applies(t))
    drawn = hashlib.sha256()

    def look(tested, case):
        drawn.update("".join(as_native([case.layout])).encode())
        drawn.update(json.dumps(case.change, sort_keys=True).encode())
        return True

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(HypothesisProvider, "_local_constants", Constants())
        patch.setattr(providers, "CONSTANTS_CACHE", LRUCache(1024))
        search(replace(asked, check=look), tested, examples=20, seed=1)
    return drawn.hexdigest()[:16]


def by_version():
    return {f"{name} {asked.version}": digest(asked) for name, asked in PROPERTIES.items()}


def test_other_cases_are_another_version():
    kept = json.loads(FILE.read_text())
    assert kept["hypothesis"] == metadata.version("hypothesis"), "write the file anew"
    found = by_version()
    changed = {name for name, said in found.items() if kept["cases"].get(name, said) != said}
    assert not changed, f"raise the version of {changed}, and write the file anew"
    assert set(found) == set(kept["cases"]), "write the file anew"


@pytest.mark.parametrize(("most", "same"), [(20, True), (8, False)])
def test_towers_of_another_height_are_other_cases(most, same):
    asked = PROPERTIES["tower"]
    other = replace(asked, cases=lambda tested: tested.within_range(towers(most=most)).map(Case))
    assert (digest(other) == digest(asked)) is same


if __name__ == "__main__":
    content = {"hypothesis": metadata.version("hypothesis"), "cases": by_version()}
    FILE.write_text(json.dumps(content, indent=1) + "\n")
