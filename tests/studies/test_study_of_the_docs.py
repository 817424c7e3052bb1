"""The study that docs/architecture.md shows is whole: a command, rows that are kept, a page."""

import importlib
import re
import sys
from pathlib import Path

import pytest
from template_names import faults_of

from steadyload.cli import main
from steadyload.reports.pages.composing import page_environment
from steadyload.studies import registry

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
MOST_LINES = 60


def files():
    """The files of the study, by path."""
    shown = r"^`(crowding/[\w.]+)` .*?^```\w+\n(.*?)^```$"
    return dict(re.findall(shown, PAGE.read_text(), re.MULTILINE | re.DOTALL))


@pytest.fixture
def crowding(tmp_path, monkeypatch):
    """The distribution of the study, found by its entry point; in a folder of its own."""
    for path, content in files().items():
        file = tmp_path / "site" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    about = tmp_path / "site" / "crowding-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: crowding\nVersion: 1.0\n")
    entry = re.search(r"`(crowding = [\w.:]+)`", PAGE.read_text())[1]
    (about / "entry_points.txt").write_text(f"[{registry.GROUP}]\n{entry}\n")
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.chdir(tmp_path)
    registry._from_other_distributions.cache_clear()
    yield
    registry._from_other_distributions.cache_clear()
    for name in [name for name in sys.modules if name.partition(".")[0] == "crowding"]:
        del sys.modules[name]


def measured(monkeypatch, ends_at=None):
    """Methods and numbers of boxes as they are measured; at some the run is interrupted."""
    loads = importlib.import_module("crowding.loads")
    seen, measure = [], loads.Loads.measure

    def counted(self):
        if (self.method, self.boxes) == ends_at:
            raise KeyboardInterrupt
        seen.append((self.method, self.boxes))
        return measure(self)

    monkeypatch.setattr(loads.Loads, "measure", counted)
    return seen


def test_it_is_short():
    assert files().keys() == {"crowding/study.py", "crowding/loads.py", "crowding/page.md.j2"}
    assert sum(len(content.splitlines()) for content in files().values()) <= MOST_LINES


def test_it_runs_goes_on_and_is_remade(crowding, monkeypatch, capsys):
    assert main(["study", "crowding", "--help"]) == 0
    told = capsys.readouterr().out
    assert "judge random loads of more and more boxes" in told
    assert "most boxes (default: 4)" in told
    assert "crowding.loads" not in sys.modules, "help imports the class alone"
    with monkeypatch.context() as first:
        seen = measured(first, ends_at=("fbs", 4))
        assert main(["study", "crowding", "--most", "5"]) == 130
        assert seen == [("fbs", 1), ("fbs", 2), ("fbs", 3)]
    assert not Path("runs/crowding/report.md").exists()
    seen = measured(monkeypatch)
    assert main(["study", "crowding", "--most", "5"]) == 0
    later = [("fbs", 4), ("fbs", 5), *(("sme", boxes) for boxes in range(1, 6))]
    assert seen == later
    text = Path("runs/crowding/report.md").read_text()
    assert text.startswith("# Random loads\n\nOf random loads ")
    assert "| method | boxes | " in text
    assert "![Random loads that stand.](figures/stand." in text
    assert len(re.findall(r"^\| (?:fbs|sme)", text, re.M)) == 10
    assert "## Made with\n\n- source: " in text
    assert main(["study", "crowding", "--most", "4"]) == 0
    kept = Path("runs/crowding/report.md").read_text()
    assert main(["pages", "remake", "crowding", "-o", "pages"]) == 0
    assert Path("pages/crowding/report.md").read_text() == kept
    assert seen == later, "rows that are kept are read"


def test_what_is_not_kept_is_not_measured_for_a_page_that_is_remade(crowding, monkeypatch, capsys):
    seen = measured(monkeypatch)
    assert main(["study", "crowding", "--most", "2"]) == 0
    assert main(["pages", "remake", "crowding", "-o", "pages"]) == 2
    assert "4 of 8 results are not kept" in capsys.readouterr().err
    assert len(seen) == 4


def test_its_template_names_what_there_is(crowding):
    assert faults_of(registry.study("crowding"), page_environment) == []
