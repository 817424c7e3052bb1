"""The pin of pages is the same twice, and a change of a page or of its keys is found."""

import json
import re
import shutil
import subprocess
import sys
import tarfile
from operator import attrgetter
from pathlib import Path

import pytest

from steadyload.studies.published import entries

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "reports" / "published"
PIN = Path(__file__).parent / "pin.py"
PAGE = "session"


def pin(*words):
    ended = subprocess.run(
        [sys.executable, PIN, *words], capture_output=True, text=True, check=False
    )
    return ended.returncode, ended.stdout + ended.stderr


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A recording of a page; the published one stays as it is meanwhile."""
    folder, published = tmp_path_factory.mktemp("pin"), ROOT / "reports" / "published" / PAGE
    before = contents(published)
    status, told = pin("record", folder, PAGE)
    assert status == 0, told
    assert contents(published) == before
    return folder


@pytest.fixture
def again(recorded, tmp_path):
    return Path(shutil.copytree(recorded, tmp_path / "again"))


def test_a_page_is_recorded_twice_to_the_same_bytes(recorded, tmp_path):
    status, told = pin("record", tmp_path, PAGE)
    assert (status, told.partition(":")[0]) == (0, PAGE)
    assert {path.relative_to(tmp_path): file for path, file in contents(tmp_path).items()} == {
        path.relative_to(recorded): file for path, file in contents(recorded).items()
    }
    assert pin("compare", recorded, tmp_path) == (0, f"{PAGE}: equal\n")


def test_a_page_says_the_revision_of_its_rows_at_every_commit(recorded):
    [told] = re.findall(
        r"^- source: .*\n", (recorded / "pages" / PAGE / "report.md").read_text(), re.M
    )
    assert told in (ROOT / "reports" / "published" / PAGE / "report.md").read_text()


def test_the_keys_are_those_of_the_rows_that_a_page_is_made_of(recorded):
    keys = json.loads((recorded / "keys" / f"{PAGE}.json").read_text())
    with tarfile.open(ROOT / "reports" / "rows" / f"{PAGE}.tar.xz") as archive:
        names = archive.getnames()
    kept = sorted(f"runs/session/{name.partition('.')[0]}" for name in names)
    assert keys == {"archive": kept, "found": kept, "absent": []}


def test_a_change_of_a_page_is_shown(recorded, again):
    page = again / "pages" / PAGE / "report.md"
    page.write_text(page.read_text().replace("# ", "# More ", 1))
    details = next(page.parent.glob("report-details.*"))
    details.rename(page.parent / "report-details.0123456789abcdef.md")
    (page.parent / "more.md").touch()
    status, told = pin("compare", recorded, again, PAGE)
    assert status == 1
    title = (recorded / "pages" / PAGE / "report.md").read_text().partition("\n")[0]
    assert told == (
        f"{PAGE}: DIFFERS\n"
        "  more.md: new\n"
        f"  {details.name}: is now report-details.0123456789abcdef.md\n"
        "  report.md: differs\n"
        "    @@ -1 +1 @@\n"
        f"    -{title}\n"
        f"    +# More {title.removeprefix('# ')}\n"
    )


def test_a_lost_key_is_shown(recorded, again):
    file = again / "keys" / f"{PAGE}.json"
    keys = json.loads(file.read_text())
    lost = keys["found"].pop()
    file.write_text(json.dumps({**keys, "absent": [lost]}))
    assert pin("compare", recorded, again) == (
        1,
        f"{PAGE}: DIFFERS\n  1 keys no longer asked for\n    {lost}\n  1 keys not found\n"
        f"    {lost}\n",
    )
    assert "  1 keys newly asked for\n" in pin("compare", again, recorded)[1]
    file.write_text(json.dumps({**keys, "archive": None}))
    assert "  keeps no rows any more\n" in pin("compare", recorded, again)[1]


def test_a_missing_page_is_a_difference(recorded, again):
    shutil.rmtree(again / "pages" / PAGE)
    missing = f"{PAGE}: DIFFERS\n  is missing in {again}\n"
    assert pin("compare", recorded, again) == (1, missing)
    file = again / "keys" / f"{PAGE}.json"
    keys = json.loads(file.read_text())
    file.write_text(json.dumps({**keys, "absent": ["runs/session/measured/0"]}))
    lost = f"{missing}  1 keys not found\n    runs/session/measured/0\n"
    assert pin("compare", recorded, again, PAGE) == (1, lost)


def test_a_published_page_is_compared_with_one_that_was_recorded(recorded, again):
    assert pin("compare", PUBLISHED, recorded, PAGE) == (0, f"{PAGE}: equal\n")
    (again / "pages" / PAGE / "written").mkdir()
    (again / "pages" / PAGE / "written" / "README.md").write_text("another\n")
    (again / "pages" / PAGE / "report.md").unlink()
    status, told = pin("compare", again, PUBLISHED, PAGE)
    assert status == 1
    assert told.startswith(f"{PAGE}: DIFFERS\n  report.md: new\n  written/README.md: differs\n")


@pytest.mark.parametrize("entry", entries(), ids=attrgetter("name"))
def test_a_published_page_is_that_of_its_kept_rows(entry, tmp_path, request):
    if "--foreign" in entry.command:
        request.getfixturevalue("aclpp_files")
    status, told = pin("record", tmp_path, entry.name)
    assert status == 0, told
    status, told = pin("compare", PUBLISHED, tmp_path, entry.name)
    assert status == 0, told


def test_wrong_words_are_refused(recorded, tmp_path):
    status, told = pin("record", tmp_path, "skale")
    assert status == 2
    assert told.startswith("pin: no page is called skale; there are evaluation, ")
    assert pin("record", recorded) == (
        2, f"pin: {recorded} holds a recording; name pages to make anew, or another folder\n",
    )  # fmt: skip
    assert pin("compare", recorded, tmp_path) == (
        2,
        f"pin: {tmp_path} holds no recording and no published pages\n",
    )
    status, told = pin("record", tmp_path / "new", "--tree", tmp_path)
    assert status == 2
    assert told.endswith(f", which is not of {tmp_path}\n")
