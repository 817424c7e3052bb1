"""Tables of field tests: what is refused, in which words, and that what is written is read."""

import csv
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.measured import field_files
from steadyload.measured.errors import FieldTestError
from steadyload.measured.field_files import COLUMNS, KNOWN, read_field_tests, write_field_tests
from steadyload.measured.field_tests import Done, FieldTest

DOCS = Path(__file__).parents[2] / "docs"
PALLET = Pallet(120.0, 200.0, 80.0)


def layout(name, *ids):
    return Layout(
        name,
        PALLET,
        tuple(
            Item(k, (30.0 * k, 0.0, 0.0), (30.0, 10.0, 30.0), 5.0, name=box)
            for k, box in enumerate(ids)
        ),
    )


ONE = layout("one", "A", "B", "C")
TWINS = layout("twins", "A", "A", "")

PLACED = {"test": "1", "plan": "one.json", "done": "placed"}
TILTED = {"test": "2", "plan": "one.json", "done": "tilted", "towards": "front", "tilt_deg": "20"}
PUSHED = {
    "test": "3", "plan": "one.json", "done": "accelerated", "towards": "45",
    "acceleration_g": "0.5",
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    write_layouts(tmp_path / "one.json", [ONE], Format.NATIVE)
    write_layouts(tmp_path / "many.json", [ONE, TWINS], Format.NATIVE)
    return tmp_path


def table(folder, *rows, before="", columns=COLUMNS):
    path = folder / "tests.csv"
    with path.open("w", newline="") as file:
        file.write(before)
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)
    return path


def refusal(path):
    with pytest.raises(FieldTestError) as caught:
        read_field_tests(path)
    told = str(caught.value)
    assert told.startswith(f"{path}: ")
    assert told.isprintable()
    assert "allowed" in told or "not CSV" in told
    return told.removeprefix(f"{path}: ")


def test_three_kinds_of_tests_are_read(folder):
    path = table(
        folder,
        PLACED | {"moved_box": "A", "moved_at_box": "C", "note": "leaned"},
        TILTED | {"moved_box": "?", "moved_at_deg": "19,5"},
        PUSHED,
    )
    placed, tilted, pushed = read_field_tests(path).tests
    assert (placed.done, placed.moved_step, placed.moved_at_step) == (Done.PLACED, 0, 2)
    assert (placed.moved, placed.reached, placed.note) == (True, None, "leaned")
    assert (tilted.towards_deg, tilted.reached, tilted.moved_at) == (90.0, 20.0, 19.5)
    assert (tilted.moved, tilted.moved_step) == (True, None)
    assert (pushed.towards_deg, pushed.reached, pushed.moved_at) == (45.0, 0.5, None)
    assert not pushed.moved
    assert {test.layout.name for test in (placed, tilted, pushed)} == {"one"}


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (PLACED | {"test": ""}, "line 2 names no test; allowed"),
        (PLACED | {"plan": "none.json"}, "test '1': plan 'none.json' is no file; allowed: a layou"),
        (PLACED | {"plan": ""}, "test '1': plan '' is no file; allowed"),
        (PLACED | {"plan": "-"}, "test '1': plan '-' is no file; allowed"),
        (PLACED | {"plan": "."}, "test '1': plan '.' is no file; allowed"),
        (PLACED | {"plan": "x" * 900}, "test '1': plan 'xxxxx"),
        (PLACED | {"plan": "tests.csv"}, "test '1': plan 'tests.csv': "),
        (PLACED | {"plan": "many.json"}, "test '1': layout is ''; allowed: one, twins, of 'many"),
        (PLACED | {"layout": "on"}, "test '1': layout is 'on'; did you mean 'one'?"),
        (PLACED | {"done": "plaecd"}, "test '1': done is 'plaecd'; did you mean 'placed'? allowed"),
        (PLACED | {"done": ""}, "test '1': done is ''; allowed: accelerated, placed, tilted"),
        (PLACED | {"done": "", "moved_box": "A"},
         "test '1': box 'A' moved in a test in which nothing was done (done is empty); allowed"),
        (TILTED | {"tilt_deg": "0", "moved_box": "A", "moved_at_deg": "3"},
         "test '2': box A (1st of 3) moved in a test in which nothing was done (tilt_deg is 0.0)"),
        (TILTED | {"tilt_deg": "", "moved_box": "A", "moved_at_deg": "3"},
         "test '2': box A (1st of 3) moved in a test in which nothing was done (tilt_deg is missi"),
        (TILTED | {"tilt_deg": ""}, "test '2': tilt_deg is missing; allowed: a number above 0, up"),
        (TILTED | {"tilt_deg": "0"}, "test '2': tilt_deg is 0.0; allowed: a number above 0, up to"),
        (TILTED | {"tilt_deg": "86"}, "test '2': tilt_deg is 86.0; allowed: a finite number, 0 to"),
        (TILTED | {"tilt_deg": "-5"}, "test '2': tilt_deg is -5.0; allowed"),
        (TILTED | {"tilt_deg": "nan"}, "test '2': tilt_deg is nan; allowed"),
        (TILTED | {"tilt_deg": "steep"}, "test '2': tilt_deg is 'steep'; allowed: a number, or"),
        (TILTED | {"towards": ""}, "test '2': towards is missing; allowed: right, front, left, ba"),
        (TILTED | {"towards": "frnt"}, "test '2': towards is 'frnt'; did you mean 'front'?"),
        (TILTED | {"towards": "361"}, "test '2': towards is 361.0; allowed: a finite number, 0 to"),
        (TILTED | {"towards": "nan"}, "test '2': towards is nan; allowed"),
        (TILTED | {"moved_at_deg": "12"}, "test '2': moved_at_deg is 12, and no box moved; allowe"),
        (TILTED | {"moved_box": "A"}, "test '2': moved_at_deg is missing, and box A (1st of 3) mo"),
        (TILTED | {"moved_box": "A", "moved_at_deg": "21"},
         "test '2': moved_at_deg is 21.0; allowed: a finite number, 0 to 20 [degrees]"),
        (TILTED | {"moved_box": "A", "moved_at_deg": "0"},
         "test '2': moved_at_deg is 0.0, and box A (1st of 3) moved; allowed: a number above 0, "),
        (TILTED | {"moved_box": "D", "moved_at_deg": "5"},
         "test '2': moved_box is 'D', which layout 'one' does not have; allowed: A, B, C; or step"),
        (TILTED | {"moved_box": "step 3", "moved_at_deg": "5"},
         "test '2': moved_box is 'step 3', which layout 'one' does not have; "),
        (TILTED | {"plan": "many.json", "layout": "twins", "moved_box": "A", "moved_at_deg": "5"},
         "test '2': moved_box is 'A', the id of several boxes; allowed: step 0, step 1"),
        (TILTED | {"acceleration_g": "0.1"}, "test '2': acceleration_g is 0.1, and the load was t"),
        (TILTED | {"moved_at_g": "0.1"}, "test '2': moved_at_g is 0.1, and the load was tilted"),
        (TILTED | {"moved_at_box": "A"}, "test '2': moved_at_box is stated, and the load was tilt"),
        (PUSHED | {"acceleration_g": "21"}, "test '3': acceleration_g is 21.0; allowed: a finite"),
        (PUSHED | {"tilt_deg": "21"}, "test '3': tilt_deg is 21, and the load was accelerated"),
        (PLACED | {"towards": "front"}, "test '1': towards_deg is 90, and the load was placed"),
        (PLACED | {"moved_at_box": "A"}, "test '1': moved_at_box is stated, and no box moved"),
        (PLACED | {"moved_box": "A"}, "test '1': box A (1st of 3) moved, and the box that was bei"),
        (PLACED | {"moved_box": "?"}, "test '1': a box moved, and the box that was being placed i"),
        (PLACED | {"moved_box": "C", "moved_at_box": "B"},
         "test '1': box C (3rd of 3) moved before it was placed (while box B (2nd of 3) was); all"),
        (PLACED | {"note": "a\x1b[2Jb"}, r"test '1': note is 'a\x1b[2Jb'; allowed: a printable te"),
    ],
)  # fmt: skip
def test_a_test_that_is_not_allowed_is_refused_by_its_name(folder, row, message):
    assert refusal(table(folder, row)).startswith(message)


def test_a_table_of_too_many_tests_is_refused(folder, monkeypatch):
    monkeypatch.setattr(field_files, "MAX_TESTS", 1)
    assert "has more than 1 tests; allowed" in refusal(table(folder, PLACED, TILTED))


def test_a_table_that_is_none_is_refused(folder):
    assert "test '1' stands there twice" in refusal(table(folder, PLACED, PLACED))
    assert "holds no tests; allowed: one row for each test" in refusal(table(folder))
    few = [name for name in COLUMNS if name != "done"]
    row = {name: PLACED.get(name, "") for name in few}
    assert "has no column 'done'; allowed: test" in refusal(table(folder, row, columns=few))
    row = PLACED | {"tilt": "4"}
    assert "has the unknown column 'tilt'; did you" in refusal(
        table(folder, row, columns=[*COLUMNS, "tilt"])
    )
    (folder / "tests.csv").write_bytes(b"test;plan\n\xe4;x\n")
    with pytest.raises(FieldTestError, match=r"is not UTF-8 text \(byte 10\); save it as UTF-8"):
        read_field_tests(folder / "tests.csv")


def test_python_is_refused_likewise():
    with pytest.raises(FieldTestError, match="moved_step is 7; allowed: 0 to 2"):
        FieldTest(name="a", plan="p", layout=ONE, done=Done.PLACED, moved=True, moved_step=7)
    with pytest.raises(FieldTestError, match="moved_step is stated, and no box moved"):
        FieldTest(name="a", plan="p", layout=ONE, done=Done.PLACED, moved_step=1)
    with pytest.raises(FieldTestError, match="a test has no name"):
        FieldTest(name="", plan="p", layout=ONE, done=Done.PLACED)


def test_comments_are_handed_out_also_as_a_spreadsheet_writes_them(folder):
    before = '# INVENTED\n\n"# with, a comma",,,,,,\n#,,,\n'
    assert read_field_tests(table(folder, PLACED, before=before)).comments == (
        "INVENTED", "with, a comma", "",
    )  # fmt: skip


def test_a_box_is_named_by_its_id_or_its_step(folder):
    rows = [
        TILTED | {"test": text, "moved_box": text, "moved_at_deg": "5", "plan": "many.json",
                  "layout": "twins"}
        for text in ("step 1", "2", "item 0")
    ]  # fmt: skip
    assert [test.moved_step for test in read_field_tests(table(folder, *rows)).tests] == [1, 2, 0]


def test_plans_are_read_as_the_caller_says(folder):
    (folder / "plan.csv").write_text(
        "layout,pallet_width,pallet_height,pallet_depth,sequence,x,y,z,width,height,depth,weight\n"
        "mm,1200,1600,800,0,0,0,0,400,300,400,12\n"
    )
    path = table(folder, PLACED | {"plan": "plan.csv"})
    [test] = read_field_tests(path, dialect=Dialect(units="mm")).tests
    assert test.layout.sizes.tolist() == [[40.0, 30.0, 40.0]]


def test_the_example_says_in_its_first_line_that_it_is_invented():
    found = read_field_tests(DOCS / "field-test" / "tests.csv")
    assert found.comments[0].startswith("INVENTED EXAMPLE")
    assert {test.done for test in found.tests} == {*Done}


def test_every_column_is_described():
    page = (DOCS / "field-test.md").read_text()
    assert {name for name in KNOWN if f"`{name}`" not in page} == set()
    assert sorted(COLUMNS) == sorted(KNOWN)


TEXTS = st.text(st.characters(categories=["L", "N", "P", "S"], include_characters=" "), max_size=12)
TEXTS = TEXTS.map(str.strip).filter(str.isprintable)
POSITIVE = st.floats(1e-3, 19.0)


@st.composite
def field_tests(draw):
    plan = draw(st.sampled_from([ONE, TWINS]))
    done = draw(st.sampled_from(Done))
    moved = draw(st.booleans())
    step = draw(st.none() | st.integers(0, 2)) if moved else None
    about = {
        "name": draw(TEXTS.filter(bool)), "plan": "many.json", "layout": plan, "done": done,
        "moved": moved, "moved_step": step, "note": draw(TEXTS),
    }  # fmt: skip
    if done is Done.PLACED:
        at = draw(st.integers(step or 0, 2)) if moved else None
        return FieldTest(**about, moved_at_step=at)
    reached = draw(POSITIVE)
    at = draw(st.floats(1e-6, reached)) if moved else None
    names = (
        ("tilt_deg", "moved_at_deg") if done is Done.TILTED else ("acceleration_g", "moved_at_g")
    )
    levels = dict(zip(names, (reached, at), strict=True))
    return FieldTest(**about, towards_deg=draw(st.floats(0.0, 360.0)), **levels)


@settings(max_examples=100)
@given(
    st.lists(field_tests(), min_size=1, max_size=4, unique_by=lambda test: test.name),
    st.lists(TEXTS.filter(lambda t: t == t.strip("# \",;\t'")), max_size=2),
)
def test_what_is_written_is_read(tmp_path_factory, drawn, comments):
    folder = tmp_path_factory.mktemp("field")
    write_layouts(folder / "many.json", [ONE, TWINS], Format.NATIVE)
    write_field_tests(folder / "tests.csv", drawn, comments)
    found = read_field_tests(folder / "tests.csv")
    assert found.comments == tuple(comments)
    for one, other in zip(drawn, found.tests, strict=True):
        for key in (*vars(one),):
            before, after = getattr(one, key), getattr(other, key)
            assert (before.name == after.name) if key == "layout" else before == after, key
