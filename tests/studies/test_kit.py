"""What is asked is measured once and kept under its key; a study is its own configuration."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from steadyload.atomic import LinkError
from steadyload.cli.studies import write
from steadyload.config import ConfigError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.reports.columns import row
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.provenance import key_of
from steadyload.studies.kit import Asked, Found, Lab, PublishedPage, Study, asked, option

ONE, OTHER = random_layouts(2, seed=5)


@row
class Part:
    size: float


@row
class Answer:
    number: int
    twice: int
    parts: Sequence[Part]
    by_name: Mapping[str, float | None]


class Number(Asked[Answer], what="twice", version=3):
    number: int
    made_by: Mapping[str, str] = asked("made by")

    def measure(self) -> Answer:
        MEASURED.append(self.number)
        if self.number < 0:
            raise KeyboardInterrupt
        return Answer(self.number, 2 * self.number, [Part(0.5), Part(1.0)], {"a": None, "b": 2.0})


MEASURED: list[int] = []
MADE = {"sme": "1"}


@pytest.fixture(autouse=True)
def nothing_measured():
    MEASURED.clear()


def stored(folder):
    return [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]


def test_a_key_is_of_all_fields_under_their_words_and_of_what_the_class_states():
    assert Number(4, MADE).key == key_of(
        {"question": "twice", "version": 3, "number": 4, "made by": MADE}
    )
    assert Number(4, MADE).describe(0) == "number 4, made_by {'sme': '1'}"


def test_a_layout_is_in_a_key_by_its_content():
    class Load(Asked[Answer], what="load"):
        layouts: tuple
        where: Path
        part: Part

        def measure(self) -> Answer:
            raise NotImplementedError

    load = Load((ONE, OTHER), Path("a"), Part(1.0))
    hashes = [ONE.content_hash(), OTHER.content_hash()]
    assert load.key == key_of(
        {"question": "load", "layouts": hashes, "where": "a", "part": {"size": 1.0}}
    )


def test_what_is_kept_is_not_measured_again(tmp_path):
    told = []
    lab = Lab(tmp_path, IN_THIS_PROCESS, lambda *at: told.append(at))
    units = [Number(3, MADE), Number(1, MADE)]
    found = lab.measure(units, Answer)
    assert MEASURED == [3, 1]
    assert [(answer.number, answer.twice) for answer in found.rows] == [(3, 6), (1, 2)]
    assert found.rows[0] == units[0].measure()
    assert {"source", "versions", "machine"} <= found.made_with.keys()
    MEASURED.clear()
    assert lab.measure(units[::-1], Answer).rows == found.rows[::-1]
    assert not MEASURED
    assert told == [("measuring", done, 2) for done in (0, 1, 2, 2)]
    assert {unit.key for unit in units} == {
        path.name.partition(".")[0] for path in (tmp_path / "measured").glob("*.json")
    }


def test_an_interrupted_run_goes_on(tmp_path):
    lab = Lab(tmp_path, IN_THIS_PROCESS)
    with pytest.raises(KeyboardInterrupt):
        lab.measure([Number(1, MADE), Number(-1, MADE), Number(2, MADE)], Answer)
    MEASURED.clear()
    lab.measure([Number(1, MADE), Number(2, MADE)], Answer)
    assert MEASURED == [2]


def test_rows_so_far_are_those_that_are_kept(tmp_path):
    lab, units = Lab(tmp_path), [Number(3, MADE), Number(1, MADE), Number(3, {"sme": "2"})]
    assert lab.so_far(units, Answer, folder="answers") == [None, None, None]
    assert list(tmp_path.iterdir()) == []
    (kept,) = lab.measure(units[1:2], Answer, folder="answers").rows
    MEASURED.clear()
    assert lab.so_far(units, Answer, folder="answers") == [None, kept, None]
    assert lab.so_far(units, Answer, folder="measured") == [None, None, None]
    assert not MEASURED


def test_what_is_asked_is_not_stored_in_its_row(tmp_path):
    Lab(tmp_path).measure([Number(4, MADE)], Answer, folder="answers")
    (record,) = stored(tmp_path / "answers")[0]
    assert record.keys() == {"twice", "parts", "by_name", "made_with"}


def test_a_kept_row_of_another_form_is_refused(tmp_path):
    @row
    class Other:
        twice: str

    lab, units = Lab(tmp_path), [Number(4, MADE)]
    lab.measure(units, Answer)
    with pytest.raises(ConfigError, match=r"kept row \w{20}: twice is 8; allowed: a text"):
        lab.measure(units, Other)


def test_a_unit_that_has_no_measure_cannot_be_made():
    class Nothing(Asked[Answer], what="nothing"):
        number: int

    with pytest.raises(TypeError, match="measure"):
        Nothing(1)


def test_a_study_is_named_after_its_package_and_has_its_options():
    class Mine(Study[Found]):
        __module__ = "outside.my_study.study"
        about, answers = "mine", "Mine?"
        boxes: int = option(3, "how many", least=1)

        def run(self, lab: Lab) -> Found:
            raise NotImplementedError

    class Other(Study[Found]):
        __module__ = "other"
        about, question, name = "other", "Other?", "else"
        pages = (PublishedPage("elsewhere"),)

        def run(self, lab: Lab) -> Found:
            raise NotImplementedError

    assert (Mine.name, Mine.command_words, Mine.work) == (
        "my_study", "study my-study", Path("runs/my_study"),
    )  # fmt: skip
    assert Mine.pages == (PublishedPage("my_study"),)
    assert [field.name for field in dataclasses.fields(Mine)] == ["boxes"]
    assert (Mine().boxes, Mine(boxes=5).boxes) == (3, 5)
    assert (Other.name, Other.command_words, Other.work) == (
        "else", "study else", Path("runs/else"),
    )  # fmt: skip
    assert Other.pages == (PublishedPage("elsewhere"),)

    class Unpublished(Mine):
        __module__ = "unpublished"
        pages = ()

        def run(self, lab: Lab) -> Found:
            raise NotImplementedError

    assert Unpublished.pages == ()


class Counting(Study[Found]):
    __module__ = "counting"
    about, answers = "counting", "How many?"

    def run(self, lab: Lab) -> Found:
        MEASURED.append(1)
        raise AssertionError("nothing is measured for a page that cannot be written")


def test_a_folder_in_which_no_page_can_stand_is_refused_before_anything_is_measured(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "figures").symlink_to(tmp_path)
    for place, error in (
        ("file", NotADirectoryError), ("file/below", NotADirectoryError), ("linked", LinkError),
    ):  # fmt: skip
        with pytest.raises(error, match=place.partition("/")[0]):
            write(Counting(), tmp_path / "work", tmp_path / place, 1)
    for folder in ("/proc", "/sys"):  # in which nobody writes, root neither
        with pytest.raises(OSError, match=folder):
            write(Counting(), tmp_path / "work", Path(folder), 1)
    assert MEASURED == []
    assert {path.name for path in tmp_path.iterdir()} == {"file", "linked"}
