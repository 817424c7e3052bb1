"""The site of docs and pages: nothing is left out, and what is linked to is there.

`make site` builds it, and fails where Sphinx finds more; here is what can be told without Sphinx.
"""

import re
import runpy
from pathlib import Path

import pytest

import steadyload

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "reports" / "published").glob("**/*.md")),
]
SITE = runpy.run_path(str(ROOT / "docs" / "conf.py"))


def links(page):
    """Files and anchors that a page leads to, other sites left out."""
    found = re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", page.read_text())
    for path, anchor in found:
        if "://" not in path:
            yield (page.parent / path).resolve() if path else page, anchor


def anchors(page):
    """Anchors of a page's headings, as Git hosts and the site name them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page):
    missing = [
        f"{file}#{anchor}"
        for file, anchor in links(page)
        if not file.exists() or (anchor and anchor not in anchors(file))
    ]
    assert not missing


def test_the_site_holds_what_its_pages_lead_to():
    recipe = re.search(r"\tcp -r --parents -t (.+?[^\\])\n", (ROOT / "Makefile").read_text(), re.S)
    copied = [ROOT / path for path in recipe[1].replace("\\\n", "").split()[1:]]
    targets = {file for page in PAGES for file, _ in links(page)}
    assert len(targets) > 100
    assert {file for file in targets if not {file, *file.parents} & set(copied)} == set()


def test_the_navigation_names_every_page_of_docs_once():
    named = [page for part in SITE["NAVIGATION"].values() for page in part]
    docs = [f"docs/{page.stem}" for page in (ROOT / "docs").glob("*.md")]
    told = sorted(page for page in named if page.startswith("docs/"))
    assert told == sorted(docs), "a page of docs is named once, in NAVIGATION of docs/conf.py"
    others = set(named) - {*docs, "api/steadyload"}
    assert {page for page in others if not (ROOT / f"{page}.md").exists()} == set()


def test_every_public_name_is_told_and_has_a_page_of_its_module():
    lines = SITE["public_names"]()
    for line, name in zip(lines, steadyload.__all__, strict=True):
        home = re.match(rf"- \{{py:obj\}}`sl\.{name} <steadyload\.([\w.]+)>`: [A-Z].*\.$", line)[1]
        assert any(home.startswith(f"{package}.") for package in SITE["PACKAGES"]), home
