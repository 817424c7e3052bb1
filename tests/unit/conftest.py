"""What tests of workers share: judges of another distribution, which do their process harm."""

import importlib
import os
import sys
from pathlib import Path

import pytest

from harness.methods import registry

_JUDGES = Path(__file__).parent / "outside" / "outside_judges.py"


@pytest.fixture
def outside(tmp_path, monkeypatch):
    """The judges of another distribution, found by entry points as an installed one's are."""
    site = tmp_path / "site"
    about = site / "outside_judges-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: outside-judges\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[steadyload.methods]\nharmful = outside_judges:Harmful\n"
    )
    (site / "outside_judges.py").write_bytes(_JUDGES.read_bytes())
    monkeypatch.syspath_prepend(site)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), *filter(None, sys.path)]))
    monkeypatch.setenv("OUTSIDE_JUDGES", str(tmp_path))
    registry._from_other_distributions.cache_clear()
    yield importlib.import_module("outside_judges")
    registry._from_other_distributions.cache_clear()
    del sys.modules["outside_judges"]
