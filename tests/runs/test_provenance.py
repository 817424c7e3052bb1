"""The revision that results name: that of the code, whatever pages were remade meanwhile."""

import subprocess

import pytest

from steadyload.runs import provenance


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A clone with a module and a published page, which the code seems to run from."""
    module = tmp_path / "harness" / "runs" / "provenance.py"
    page = tmp_path / "reports" / "published" / "report.md"
    for file in (module, page):
        file.parent.mkdir(parents=True)
        file.write_text("1\n")
    who = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], [*who, "commit", "-qm", "first"]):
        subprocess.run(["git", "-C", str(tmp_path), *words], check=True)
    monkeypatch.setattr(provenance, "__file__", str(module))
    return module, page


def test_a_page_that_was_remade_leaves_the_revision_clean(tree):
    module, page = tree
    clean = provenance.provenance()["git"]
    assert len(clean) == 12
    page.write_text("2\n")
    assert provenance.provenance()["git"] == clean
    module.write_text("2\n")
    assert provenance.provenance()["git"] == f"{clean}-dirty"


def test_outside_a_clone_there_is_no_revision(tree):
    module, _ = tree
    subprocess.run(["rm", "-rf", str(module.parents[2] / ".git")], check=True)
    assert provenance.provenance()["git"] is None
