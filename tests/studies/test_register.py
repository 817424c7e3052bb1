"""The register of what was chosen and measured on which part is what the files say."""

import io
import json
import re
import tarfile
from collections import defaultdict
from pathlib import Path

import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import set_named
from steadyload.layouts.model.question import with_question
from steadyload.learners.weights import load_weights, shipped_weights
from steadyload.methods.contract.method import Status
from steadyload.studies.kept_rows import MADE_WITH, _content
from steadyload.studies.published import FOLDER, ROWS

ROOT = Path(__file__).parents[2]
LARGE = "benchmark"
ANY_SET = r"(?:the set `(\w+)`|the large set of the package)"
OWN = "replication"
"""The page that packs and labels a set of its own."""


def rows(heading):
    """Cells of the lines of a table of the register."""
    text = (ROOT / "docs" / "register.md").read_text().partition(f"## {heading}\n")[2]
    found = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)
    _, _, *lines = found[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def stored(file):
    return json.loads((ROOT / "harness" / "methods" / file).read_text())


def version(made_by):
    return made_by["versions"]["steadyload"]


def searched():
    """Parts that presets were searched on, and the version, by spec."""
    for record in stored("tuned.json")["tuned"]:
        source = record["made_by"]["source"]
        parts = [f"{source['directory'] or LARGE} {source['part']}"]
        parts += [f"{other} validation" for other in source.get("data", ())]
        spec = with_question(f"{record['preset']}@{record['engine']}", record["question"])
        yield spec, (", ".join(parts), version(record["made_by"]))


def fitted():
    """The same of thresholds of cascades."""
    for record in stored("cascades.json")["fitted"]:
        made_by = record["made_by"]
        parts = [f"{made_by['directory']} fitting"]
        parts += [f"{other} validation" for other in made_by["data"]]
        if falls := made_by.get("falls"):
            parts += [f"{falls} train", f"{falls} validation"]
        spec = with_question(f"cascade@{record['engine']}", record["question"])
        yield spec, (", ".join(parts), version(made_by))


def trained():
    """The same of networks, of which parts `train` and `validation` take part."""
    for name in shipped_weights():
        manifest = load_weights(name).manifest
        spec = name.replace("-stands", ":question=stands")
        sets = ", ".join(own["name"] for own in manifest["data"])
        yield spec, (sets, version(manifest["made_by"]))


def test_the_register_has_all_that_was_chosen_and_on_which_parts():
    said = {
        spec: (on, when)
        for what, _, on, when in rows("What was chosen")
        for spec in re.findall(r"`([^`]+)`", what)
    }
    found = dict([*searched(), *fitted(), *trained()])
    assert said == found
    assert not any(re.search(r"\btest\b|\blists\b", parts) for parts, _ in found.values())


def measured():
    """Pages with the day of their last rows, by labelled set, of test parts: as the manifests of
    their rows say, or the page.
    """
    found = defaultdict(lambda: defaultdict(str))
    for page in (ROOT / FOLDER).glob("*/report.md"):
        text = "".join(own.read_text() for own in page.parent.glob("report*.md"))
        begun = re.search(r"^- started: (\S+?)T", text, re.MULTILINE)
        for name in re.findall(rf"part `?test`? of {ANY_SET}", text):
            found[name or LARGE][page.parent.name] = begun[1] if begun else ""
    for file in {*(ROOT / ROWS).glob("*.*")} - {ROOT / ROWS / "README.md", ROOT / ROWS / MADE_WITH}:
        content = _content(file, beside=file.suffix == ".parquet")
        with tarfile.open(fileobj=io.BytesIO(content)) as archive:
            for member in archive:
                if Path(member.name).name == "manifest.json":
                    manifest = json.load(archive.extractfile(member))
                    about = manifest.get("labels") or {}
                    if about.get("part") == "test":
                        pages, page = found[about.get("set", LARGE)], file.name.partition(".")[0]
                        pages[page] = max(pages[page], manifest["started"].partition("T")[0])
    return found


def test_the_register_has_every_page_that_measures_on_a_test_part():
    said = {
        what.split()[0].strip("`"): pages.split(", ")
        for what, _, pages in rows("What was measured")
    }
    found = {
        name: [f"{page} {day}".strip() for page, day in sorted(pages.items()) if page != OWN]
        for name, pages in measured().items()
    }
    assert said == found


@pytest.mark.parametrize("line", rows("What was measured"), ids=lambda line: line[0])
def test_the_register_counts_item_lists(line):
    name, count, _ = line
    name = name.split()[0].strip("`")
    cases = load_benchmark(None if name == LARGE else set_named(name)).cases
    own = cases[(cases["split"] == "test") & (cases["status"] == Status.DONE)]
    assert own["instance"].nunique() == int(count)
