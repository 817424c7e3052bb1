"""Trials and their files: what is refused, in which words, and that what is written is read."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import CUBE, free_flight, resting, turned

from steadyload.errors import UserError
from steadyload.measured import motion_files
from steadyload.measured.bodies import Body
from steadyload.measured.derived import spins, velocities
from steadyload.measured.errors import MotionError
from steadyload.measured.motion import Trial
from steadyload.measured.motion_files import KNOWN, REQUIRED, read_motion, write_motion

DOCS = Path(__file__).parents[2] / "docs"
HEADER = "trial,time,x,y,z,qw,qx,qy,qz"
ROWS = ["a,0,0,0,1,1,0,0,0", "a,0.1,0,0,1,1,0,0,0", "a,0.2,0,0,1,1,0,0,0"]


def file_of(folder, header=HEADER, rows=ROWS):
    path = folder / "motion.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def refusal(path, **reading):
    with pytest.raises(MotionError) as caught:
        read_motion(path, **reading)
    told = str(caught.value)
    assert told.startswith(f"{path}: ")
    assert told.isprintable()
    assert "allowed" in told or "save it" in told or "not CSV" in told
    return told.removeprefix(f"{path}: ")


def changed(place, cells):
    """Rows of which one has other cells, by place."""
    rows = [row.split(",") for row in ROWS]
    for column, cell in cells.items():
        rows[place][column] = cell
    return [",".join(row) for row in rows]


@pytest.mark.parametrize(
    ("place", "cells", "message"),
    [
        (1, {2: "nan"}, "trial 'a', frame 1: x is nan; allowed: a finite number, -1000 to 1000 [m"),
        (2, {4: "inf"}, "trial 'a', frame 2: z is inf; allowed"),
        (1, {1: "nan"}, "trial 'a', frame 1: time is nan; allowed: a finite number"),
        (0, {5: "-inf"}, "trial 'a', frame 0: qw is -inf; allowed"),
        (1, {3: "north"}, "line 3: y is 'north'; allowed: a number"),
        (1, {3: ""}, "trial 'a', frame 1: y is missing; allowed: a number"),
        (1, {1: ""}, "trial 'a', frame 1: time is missing; allowed: a number"),
        (2, {1: "0.1"}, "trial 'a', frame 2: time 0.1 stands there twice; allowed: times that ris"),
        (2, {1: "0.05"}, "trial 'a', frame 2: time 0.05 follows 0.1; allowed: times that rise [s]"),
        (1, {1: "1e-9"}, "trial 'a', frame 1: is 1e-09 s after the one before; allowed: 1e-0"),
        (2, {1: "1e6"}, "trial 'a', frame 2: is 1e+06 s after the one before; allowed: 1e-0"),
        (1, {5: "0.9"}, "trial 'a', frame 1: its quaternion has the length 0.9; allowed: 1, to"),
        (1, {5: "0"}, "trial 'a', frame 1: its quaternion has the length 0; allowed: 1"),
        (2, {0: ""}, "line 4 names no trial; allowed: its name in every row"),
        (2, {0: "b"}, "trial 'a' has 2 frames; allowed: 3 or more"),
        (1, {2: "100"}, "trial 'a', frame 1: has moved at 1e+03 m/s since the frame before; allow"),
        (1, {2: "5000"}, "trial 'a', frame 1: x is 5000; allowed: a finite number, -1000 to 1000"),
    ],
)  # fmt: skip
def test_a_row_that_is_not_allowed_is_refused_by_trial_and_frame(tmp_path, place, cells, message):
    assert refusal(file_of(tmp_path, rows=changed(place, cells))).startswith(message)


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("trial,time,x,y,z,qw,qx,qy", "a,0,0,0,1,1,0,0", "has no column 'qz'; allowed: trial, tim"),
        (f"{HEADER},speed", f"{ROWS[0]},1", "has the unknown column 'speed'; "),
        (f"{HEADER},mas", f"{ROWS[0]},1", "has the unknown column 'mas'; did you mean 'mass'?"),
        (f"{HEADER},X", f"{ROWS[0]},1", "has the column 'x' twice; allowed: once"),
        (f"{HEADER},vx,vy", f"{ROWS[0]},0,0", "has no column 'vz', and has 'vx'; allowed: all of"),
        (f"{HEADER},size_x", f"{ROWS[0]},1", "has no column 'size_y', and has 'size_x'; allowed"),
        (HEADER, f"{ROWS[0]},7", "line 2 has 10 values; allowed: 9, as the header says"),
        (HEADER, '"a', "line 2 is not CSV"),
        (HEADER, "", "holds no frames; allowed: one row for each frame of a trial"),
        ("", "", "has no header; allowed: a line of names"),
        (HEADER, "x" * 1001, "line 2 has a cell of 1001 characters; allowed: 1000"),
    ],
)  # fmt: skip
def test_a_file_of_other_columns_is_refused(tmp_path, header, row, message):
    assert refusal(file_of(tmp_path, header, [row])).startswith(message)


def with_body(cells):
    """A header and rows with further columns, each of them constant, or of a value a frame."""
    values = {k: v if isinstance(v, list) else [v] * 3 for k, v in cells.items()}
    rows = [",".join([row, *(v[k] for v in values.values())]) for k, row in enumerate(ROWS)]
    return ",".join([HEADER, *values]), rows


SIZE = {"size_x": "0.1", "size_y": "0.1", "size_z": "0.1"}
INERTIA = {"inertia_x": "1e-4", "inertia_y": "1e-4", "inertia_z": "1e-4"}


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ({**SIZE, "size_y": "0"}, "trial 'a': size_y is 0.0; allowed: a finite number, 0.001 to 2"),
        ({**SIZE, "size_y": "-0.1"}, "trial 'a': size_y is -0.1; allowed"),
        (dict.fromkeys(SIZE, "104.8"), "trial 'a': size_x is 104.8; allowed: a finite number, 0.0"),
        (dict.fromkeys(SIZE, "10.48"), "trial 'a', frame 0: its lowest corner is 4.24 m below the"),
        ({"mass": "0"}, "trial 'a': mass is 0.0; allowed: a finite number, 1e-06 to 100000 [kg]"),
        ({"mass": "nan"}, "trial 'a': mass is nan; allowed"),
        ({"mass": ["1", "1", "2"]}, "trial 'a': frame 2: mass is 2, and 1 in the first; allowed:"),
        ({"mass": ["1", "", "1"]}, "trial 'a': frame 1: mass is missing, and 1 in the first; allo"),
        ({**SIZE, "mass": "370"}, "trial 'a': a mass of 370 kg in 0.1 x 0.1 x 0.1 m is 3.7e+05 kg"),
        ({**INERTIA, "inertia_x": "3e-4"}, "trial 'a': moments of inertia are 0.0003, 0.0001, 0.0"),
        ({**INERTIA, "inertia_z": "-1e-4"}, "trial 'a': inertia_z is -0.0001; allowed"),
        ({**SIZE, **INERTIA, "mass": "0.01"}, "trial 'a': inertia_x is 0.0001; allowed: up to 5e-"),
        ({"friction": "-0.1"}, "trial 'a': friction is -0.1; allowed: a finite number, 0 to 10"),
        ({"restitution": "1.5"}, "trial 'a': restitution is 1.5; allowed: a finite number, 0 to 1"),
        ({**SIZE, "size_y": ""}, "trial 'a': only some of size_x, size_y, size_z are given; allow"),
        ({"vx": "0", "vy": ["0", "", "0"], "vz": "0"}, "trial 'a', frame 1: vy is missing; allowe"),
        ({"vx": "0", "vy": "nan", "vz": "0"}, "trial 'a', frame 0: vy is nan; allowed"),
        ({"vx": "120", "vy": "0", "vz": "0"}, "trial 'a', frame 0: vx is 120; allowed"),
        ({"vx": "40", "vy": "0", "vz": "0"}, "trial 'a': its velocities move it by 8 m, its posit"),
        ({"wx": "57", "wy": "0", "wz": "0"}, "trial 'a': its angular velocities turn it by 11.4 r"),
    ],
)  # fmt: skip
def test_a_body_or_a_velocity_that_is_not_allowed_is_refused(tmp_path, cells, message):
    assert refusal(file_of(tmp_path, *with_body(cells))).startswith(message)


def test_speeds_in_cm_a_second_and_degrees_a_second_are_refused():
    flight = free_flight()
    with pytest.raises(MotionError, match=r"velocities move it by .*positions in m and velocities"):
        replace(flight, velocities=velocities(flight)[:, :] * 100.0 / 2.5)
    with pytest.raises(MotionError, match=r"angular velocities turn it by .*, in rad/s"):
        replace(flight, spins=np.degrees(spins(flight)))


def test_a_body_whose_y_points_up_is_refused():
    flat = resting(body=CUBE)
    with pytest.raises(MotionError, match=r"lowest corner is 0.15 m below the floor; .*z up"):
        replace(flat, positions=flat.positions - (0.0, 0.0, 0.15))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Trial("a", [0, 1], np.zeros((2, 3)), np.zeros((2, 4))), "has 2 frames"),
        (
            lambda: Trial("a", [[0], [1]], np.zeros((2, 3)), np.zeros((2, 4))),
            "times have the shape",
        ),
        (lambda: Trial("a", "now", None, None), "times have the shape|times are no numbers"),
        (lambda: Trial("a", [0, 1, 2], np.zeros((2, 3)), np.zeros((3, 4))), r"allowed: \(3, 3\)"),
        (lambda: Trial("\x1b", [0, 1, 2], np.zeros((3, 3)), np.zeros((3, 4))), "is called"),
        (lambda: Body(size=(1, 2)), "allowed: three numbers"),
        (lambda: Body(size=1.0), "allowed: three numbers"),
        (lambda: Body(mass="heavy"), "mass is 'heavy'"),
    ],
)
def test_what_python_hands_over_is_checked_likewise(make, message):
    with pytest.raises(MotionError, match=message):
        make()


def test_arrays_are_read_only_and_no_others():
    times = np.arange(3.0)
    trial = Trial("a", times, np.zeros((3, 3)), np.tile([1.0, 0, 0, 0], (3, 1)))
    times[0] = -1.0
    assert trial.times[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        trial.positions[0] = 1.0


def test_corners_are_those_of_the_box():
    body = Body(size=(0.2, 0.4, 0.6))
    quarter = turned((0.0, 0.0, 1.0), [math.pi / 2] * 3)
    trial = Trial("a", [0, 1, 2], np.tile([1.0, 2.0, 0.3], (3, 1)), quarter, body=body)
    assert trial.corners[0].min(axis=0) == pytest.approx([0.8, 1.9, 0.0])
    assert trial.corners[0].max(axis=0) == pytest.approx([1.2, 2.1, 0.6])


def test_names_and_constants_of_the_caller(tmp_path):
    header = "toss,frame,t,x,y,z,qw,qx,qy,qz"
    rows = [row.replace("a,", f"7,{k},") for k, row in enumerate(ROWS)]
    path = file_of(tmp_path, header, rows)
    named = {"columns": {"trial": "toss", "time": "t"}, "ignored": ["frame"]}
    [trial] = read_motion(path, **named, constants={"mass": 0.5})
    assert (trial.name, trial.body.mass, trial.body.size) == ("7", 0.5, None)
    assert "unknown column 'toss'; allowed: friction, " in refusal(path)
    assert refusal(path).endswith("; a profile (--profile) says which columns have other names or "
                                  "are ignored")  # fmt: skip
    assert "has no column 'toss'" in refusal(file_of(tmp_path), **named)


@pytest.mark.parametrize(
    ("reading", "message"),
    [
        ({"columns": {"when": "t"}}, "columns: unknown column 'when'; allowed"),
        ({"constants": {"weight": 1}}, "constants: unknown quantity 'weight'; "),
        ({"constants": {"mass": "heavy"}}, "constants: mass is 'heavy'; allowed: a number"),
        ({"constants": {"size_x": 0.1}}, "has no column 'size_y', and has 'size_x'"),
    ],
)
def test_names_that_there_are_not_are_refused(tmp_path, reading, message):
    with pytest.raises(MotionError, match=message):
        read_motion(file_of(tmp_path), **reading)


def test_a_constant_and_a_column_are_not_both_allowed(tmp_path):
    path = file_of(tmp_path, *with_body({"mass": "1"}))
    assert "has a column 'mass', and a constant" in refusal(path, constants={"mass": 2.0})


def test_trials_may_alternate_and_decimal_commas_are_read(tmp_path):
    rows = [
        r.replace("a,", f"{n},").replace(",", ";").replace(".", ",") for r in ROWS for n in "ba"
    ]
    trials = read_motion(file_of(tmp_path, HEADER.replace(",", ";"), rows))
    assert [trial.name for trial in trials] == ["b", "a"]
    assert trials[1].times.tolist() == [0.0, 0.1, 0.2]


def table(**columns):
    flat = {name: [float(name in ("z", "qw"))] * 3 for name in REQUIRED[2:]}
    return pa.table({"trial": [1, 1, 1], "time": [0.0, 0.1, 0.2], **flat, **columns})


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"x": ["0", "0", "0"]}, "x is a column of string; allowed: numbers"),
        ({"x": [True, True, True]}, "x is a column of bool; allowed: numbers"),
        ({"trial": [0.5, 0.5, 0.5]}, "trial is a column of double; allowed: texts or whole"),
        ({"trial": ["a", None, "a"]}, "row 1 names no trial; allowed"),
        ({"x": [0.0, None, 0.0]}, "trial '1', frame 1: x is missing"),
        ({"x": [0.0, math.nan, 0.0]}, "trial '1', frame 1: x is nan"),
        ({"mass": [math.nan] * 3}, "trial '1': mass is nan"),
        ({"height": [1.0] * 3}, "has the unknown column 'height'"),
        ({"x": pa.nulls(3)}, "trial '1', frame 0: x is missing"),
    ],
)
def test_a_parquet_file_is_checked_likewise(tmp_path, columns, message):
    path = tmp_path / "motion.parquet"
    pq.write_table(table(**columns), path)
    assert refusal(path).startswith(message)


def test_a_parquet_file_with_a_column_twice_is_refused(tmp_path):
    path, whole = tmp_path / "motion.parquet", table()
    pq.write_table(whole.append_column("x", whole.column("y")), path)
    assert refusal(path).startswith("has the column 'x' twice; allowed: once")


@pytest.mark.parametrize("kind", [pa.string(), pa.large_string(), pa.string_view()], ids=str)
def test_names_of_every_kind_of_text_are_read(tmp_path, kind):
    path = tmp_path / "motion.parquet"
    names = pa.array(["a", "a", "a"], kind)
    pq.write_table(table(trial=names, mass=pa.nulls(3)), path)
    (trial,) = read_motion(path)
    assert (trial.name, trial.body.mass) == ("a", None)


def test_a_trial_of_many_minutes_is_refused():
    times = np.arange(0.0, 611.0, 10.0)
    still, upright = np.zeros((len(times), 3)), np.tile([1.0, 0, 0, 0], (len(times), 1))
    assert len(Trial("a", times[:-1], still[:-1], upright[:-1])) == 61
    with pytest.raises(MotionError, match="trial 'a': lasts 610 s; allowed: up to 600 s"):
        Trial("a", times, still, upright)


def test_a_trial_without_positions_is_refused(tmp_path):
    rows = [row.replace(",0,0,1,1", ",,,,1") for row in ROWS]
    assert refusal(file_of(tmp_path, rows=rows)).startswith("trial 'a', frame 0: x is missing")


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_file_of_too_many_frames_or_trials_is_refused(tmp_path, monkeypatch, ending):
    path = tmp_path / f"motion.{ending}"
    write_motion(path, [resting(), free_flight()])
    monkeypatch.setattr(motion_files, "MAX_TRIALS", 1)
    assert refusal(path) == "holds 2 trials; allowed: up to 1"
    monkeypatch.setattr(motion_files, "MAX_FRAMES", 30)
    assert refusal(path) == "holds more than 30 frames; allowed: up to so many"


def test_a_parquet_file_that_is_cut_off_is_refused(tmp_path):
    path = tmp_path / "motion.parquet"
    pq.write_table(table(), path)
    assert len(read_motion(path)) == 1
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(MotionError, match="is no Parquet file that can be read"):
        read_motion(path)


def test_a_quantity_that_only_some_trials_have(tmp_path):
    known, unknown = resting(body=CUBE), free_flight()
    write_motion(tmp_path / "two.csv", [known, unknown])
    first, second = read_motion(tmp_path / "two.csv")
    assert (first.body, second.body) == (CUBE, Body())


@pytest.mark.parametrize(
    ("name", "trials", "message"),
    [
        ("motion.txt", [resting()], "ends in '.txt'; allowed: .csv, .parquet"),
        (
            "motion.csv",
            [resting(), resting()],
            "trial 'rest'; allowed: one or more, each name once",
        ),
        ("motion.csv", [], "allowed: one or more"),
        ("motion.csv", [replace(resting(), name=" a")], "without blanks"),
    ],
)
def test_what_cannot_be_read_back_is_not_written(tmp_path, name, trials, message):
    with pytest.raises(MotionError, match=message):
        write_motion(tmp_path / name, trials)


NUMBERS = st.floats(-9.0, 9.0)
BODIES = st.builds(
    Body,
    size=st.none() | st.tuples(*[st.floats(0.001, 0.5)] * 3),
    mass=st.none(),
    inertia=st.none() | st.tuples(*[st.floats(0.1, 0.19)] * 3),
    friction=st.none() | st.floats(0.0, 2.0),
    restitution=st.none() | st.floats(0.0, 1.0),
)
NAMES = st.text(st.characters(categories=["L", "N", "P", "S"]), min_size=1, max_size=12)


@st.composite
def trials(draw):
    count = draw(st.integers(3, 6))
    steps = draw(st.lists(st.floats(0.5, 3.0), min_size=count, max_size=count))
    times = draw(NUMBERS) + np.cumsum(steps)
    places = draw(st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=count, max_size=count))
    axis = draw(st.tuples(*[st.floats(0.1, 1.0)] * 3))
    attitudes = turned(axis, draw(st.lists(NUMBERS, min_size=count, max_size=count)))
    lifted = np.array(places) + np.array([0.0, 0.0, 10.0])
    bare = Trial(draw(NAMES), times, lifted, attitudes, body=draw(BODIES))
    given = {}
    if draw(st.booleans()):
        # velocities whose integral is that of the positions
        given["velocities"] = np.tile((lifted[-1] - lifted[0]) / (times[-1] - times[0]), (count, 1))
    if draw(st.booleans()):
        given["spins"] = 0.1 * spins(bare)
    try:
        return replace(bare, **given)
    except UserError:
        return bare


@settings(max_examples=60)
@pytest.mark.parametrize("ending", ["csv", "parquet"])
@given(drawn=st.lists(trials(), min_size=1, max_size=3, unique_by=lambda trial: trial.name))
def test_what_is_written_is_read(tmp_path_factory, ending, drawn):
    path = tmp_path_factory.mktemp("motion") / f"trials.{ending}"
    write_motion(path, drawn)
    found = read_motion(path)
    assert [trial.name for trial in found] == [trial.name for trial in drawn]
    for one, other in zip(drawn, found, strict=True):
        assert one.body == other.body
        for key in ("times", "positions", "attitudes", "velocities", "spins"):
            before, after = getattr(one, key), getattr(other, key)
            assert (before is None) == (after is None)
            assert before is None or np.array_equal(before, after)


def test_every_column_is_described():
    page = (DOCS / "measured.md").read_text()
    assert {name for name in KNOWN if f"`{name}`" not in page} == set()
