"""The static site: README, docs and published pages at their own paths, and the API of docstrings.

``make site`` copies what is shown into one folder, so that links between pages lead to the same
places as in the repository, and has Sphinx build it. A link that leads nowhere ends the build.
"""

from __future__ import annotations

import inspect
import pkgutil
import re
import shutil
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "steadyload"
root_doc = "README"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

html_theme = "furo"
html_title = project
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_show_search_summary = False  # it is fetched, which no browser allows of a file

myst_enable_extensions = ["html_image"]
myst_heading_anchors = 4

autodoc_default_options = {"members": True, "ignore-module-all": True}
autodoc_member_order = "bysource"
napoleon_attr_annotations = False
napoleon_use_ivar = True

NAVIGATION = {
    "Start": ["docs/tour", "docs/installing", "CHANGELOG"],
    "My pallets": [
        "docs/check",
        "docs/repair",
        "docs/pallets",
        "docs/layouts",
        "docs/view",
        "docs/packers",
        "docs/session",
        "docs/transport",
        "docs/bearing",
        "docs/uncertainty",
        "docs/wrong_input",
    ],
    "Compare": [
        "docs/studies",
        "docs/methods",
        "docs/engines",
        "docs/extremes",
        "docs/cascade",
        "docs/tuning",
        "docs/learners",
        "docs/benchmark",
        "docs/register",
        "docs/measured",
        "docs/reality",
        "docs/field-test",
        "harness/layouts/benchmark/THIRD-PARTY",
        "docs/cluster",
    ],
    "Concepts": [
        "docs/reference",
        "docs/siconos",
        "docs/properties",
        "docs/architecture",
        "docs/testing",
        "docs/numbers",
    ],
    "Glossary": ["docs/glossary"],
    "API": ["docs/api", "api/steadyload"],
    "Gallery": ["reports/published/README"],
}
"""Part of the site -> its pages, in order; a page that is not there is left out."""

PACKAGES = (
    "layouts",
    "methods",
    "bearing",
    "transport",
    "measured",
    "engines",
    "runs",
    "statistics",
    "tuning",
    "learners",
    "properties",
    "gym",
    "app.checking",
    "app.repairs",
    "app.repair_results",
    "app.repaired_files",
    "app.viewing",
    "studies.kept_rows",
)
"""Packages and modules below ``steadyload`` of which every module has a page of API."""

INTERACTIVE = "interactive.html"
"""Name in the site of the file beside a published page whose name the page itself takes."""


def setup(app: Sphinx) -> None:
    """Have pages of API and the navigation written while Sphinx reads, and files copied after."""
    app.connect("builder-inited", write_api)
    app.connect("autodoc-process-docstring", suit_napoleon, priority=1)
    app.connect("source-read", add_navigation)
    app.connect("build-finished", copy_files)


def suit_napoleon(
    _app: Sphinx, what: str, _name: str, _found: object, _options: object, lines: list[str]
) -> None:
    """Have no word before a colon taken for a type: of a value's text, or of one of two names."""
    for number, line in enumerate(lines):
        names = re.match(r" +\w+(?:, \w+)+(?=: )", line)
        if names:
            lines[number] = names[0].replace(", ", ",") + line[names.end() :]
    if what in ("attribute", "data", "property"):
        lines.insert(0, "")


def write_api(app: Sphinx) -> None:
    """Write the source of a page of the public names, and of one for each public module."""
    folder = Path(app.srcdir) / "api"
    folder.mkdir(exist_ok=True)
    packages = [f"{project}.{package}" for package in PACKAGES]
    (folder / f"{project}.md").write_text(
        "# All public names\n\nOf `import steadyload as sl`; below them, the packages that they "
        "come from.\n\n"
        + "\n".join(public_names())
        + _contents([f"{name} <{name}>" for name in packages], hidden=False)
    )
    for package in packages:
        path = getattr(import_module(package), "__path__", [])
        inner = [module.name for module in pkgutil.walk_packages(path, f"{package}.")]
        contents = [f"{name.removeprefix(f'{package}.')} <{name}>" for name in inner]
        for name in (package, *inner):
            text = f"# {name}\n\n```{{eval-rst}}\n.. automodule:: {name}\n```\n"
            text += _contents(contents, hidden=False) if contents and name == package else ""
            (folder / f"{name}.md").write_text(text)


def public_names() -> list[str]:
    """A line of Markdown for every name of ``import steadyload as sl``."""
    package = import_module(project)
    lines = []
    for name in package.__all__:
        found = getattr(package, name)
        first = " ".join((inspect.getdoc(found) or "").partition("\n\n")[0].split())
        said = re.sub(r":\w+:(?=`)", "", first).replace("``", "`")
        lines.append(f"- {{py:obj}}`sl.{name} <{found.__module__}.{found.__qualname__}>`: {said}")
    return lines


def add_navigation(app: Sphinx, page: str, source: list[str]) -> None:
    """Append the parts of the site to its start page, the published pages to their index, and a
    link to a published page whose file for browsers is there.
    """
    folder = Path(app.srcdir)
    if page == root_doc:
        for part, pages in NAVIGATION.items():
            there = [f"/{name}" for name in pages if (folder / f"{name}.md").exists()]
            source[0] += _contents(there, caption=part)
    elif page == "reports/published/README":
        pages = sorted((folder / page).parent.glob("*/report.md"))
        source[0] += _contents([f"/{path.relative_to(folder)}" for path in pages])
    elif page.startswith("reports/published/"):
        if (folder / f"{page}.html").exists():
            link = f'\n\n<a href="{INTERACTIVE}">The same page to sort, filter and ask</a>\n'
            source[0] = source[0].replace("\n", link, 1)
        for path in (folder / page).parent.glob(f"{Path(page).name}-details*.md"):
            source[0] += _contents([f"/{path.relative_to(folder).with_suffix('')}"])


def _contents(pages: list[str], caption: str = "", *, hidden: bool = True) -> str:
    """A table of contents, in the Markdown of MyST."""
    options = [f":caption: {caption}"] * bool(caption) + [":hidden:"] * hidden + [":maxdepth: 1"]
    return "\n".join(["\n\n```{toctree}", *options, "", *pages, "```\n"])


def copy_files(app: Sphinx, error: Exception | None) -> None:
    """Copy the start page to the name that a folder answers with, and files for browsers."""
    if error is None:
        source, site = Path(app.srcdir), Path(app.outdir)
        shutil.copyfile(site / f"{root_doc}.html", site / "index.html")
        for path in source.glob("reports/published/*/report.html"):
            shutil.copyfile(path, (site / path.relative_to(source)).with_name(INTERACTIVE))
