"""The extremes: measures against closed forms, the running of cells, envelopes, what is shown."""

import dataclasses
import json
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from steadyload.config import ConfigError
from steadyload.engines import registry
from steadyload.engines.registry import engines, open_world
from steadyload.engines.world import (
    GRAVITY,
    Box,
    Poses,
    Velocities,
    WorldSettings,
)
from steadyload.methods.envelope import Envelope, envelopes
from steadyload.properties import mechanics
from steadyload.properties.closed_forms import Stage
from steadyload.runs.provenance import provenance
from steadyload.statistics.estimate import Estimate
from steadyload.stored import stored_object
from steadyload.studies.changed_loads import DISTANCES, SCALES
from steadyload.studies.extremes import loads, scenes
from steadyload.studies.extremes import measuring as extreme_runs
from steadyload.studies.extremes import running as extreme_cells
from steadyload.studies.extremes.envelopes import (
    ENVELOPE_SWEEPS,
    EnvelopeRow,
    envelope_file,
    envelope_rows,
    from_here_on,
    write_envelopes,
)
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.running import run_extremes
from steadyload.studies.extremes.showing import shown
from steadyload.studies.extremes.study import Extremes
from steadyload.studies.extremes.sweeps import (
    FREQUENCIES,
    SWEEPS,
    ExtremeCell,
    measure_cell,
)
from steadyload.studies.kit import Lab

CHANGES = dict.fromkeys((*DISTANCES, *SCALES), Estimate(0.1, 0.0, 0.3, 10))
LOADS = loads.Loads([loads.Engine("bullet", False, CHANGES, CHANGES, CHANGES)], 10, 10, [])
PUBLISHED = Path(__file__).resolve().parents[2] / "reports" / "published" / "extremes"

# --- measures -----------------------------------------------------------------------------------


def test_what_is_in_balance_stays_and_what_is_not_falls(engine):
    """A plate past an edge turns as the pendulum does; the settled pair keeps its height."""
    stage = Stage(engine, 240)
    rest = extreme_runs.settle(stage, scenes.tower(2))
    assert rest.outcome is Outcome.CLOSE
    assert rest.numbers["moved"] < 1.0
    assert -1.0 < rest.numbers["energy"] < 0.01
    assert 0.0 <= rest.numbers["penetration"] < 1.0
    fallen = extreme_runs.settle(stage, scenes.plate_on_table(0.2))
    assert fallen.outcome is Outcome.FAILED
    past = extreme_runs.plate(stage, 0.1)
    assert past.outcome is Outcome.CLOSE
    length, thick, _ = 1.0, 0.01, 0
    time = mechanics.tipping_time((length, thick), 0.1, np.radians(past.numbers["turned"]))
    assert time == pytest.approx(extreme_runs.SECONDS, rel=0.05)
    assert extreme_runs.plate(stage, -0.05).outcome is Outcome.CLOSE


def test_a_tower_that_leans_is_held_but_not_at_rest():
    high = measure_cell("tower", "bullet", 60, 15)
    assert high.outcome is Outcome.HELD
    assert 1.0 < high.numbers["moved"] <= 100.0
    assert measure_cell("tower", "bullet", 60, 40).outcome is Outcome.FAILED


def test_small_boxes_are_held_by_their_own_edge():
    boxes = scenes.tower(2, 0.01)
    table = [dataclasses.replace(boxes[0], fixed=True), dataclasses.replace(
        boxes[1], centre=(0.0, 0.0, boxes[1].centre[2] + 0.02)
    )]  # fmt: skip
    # It falls by 2 cm: less than 10 cm, more than its edge of 1 cm.
    stage = Stage("mujoco", 240)
    assert extreme_runs.settle(stage, table).outcome is Outcome.HELD
    assert extreme_runs.settle(stage, table, sized=True).outcome is Outcome.FAILED


def test_penetration_is_how_far_neighbours_have_approached():
    boxes = scenes.pile(8, 3)
    planned = np.array([box.centre for box in boxes])
    still = np.tile((1.0, 0.0, 0.0, 0.0), (8, 1))

    def found(moves):
        centres = planned.copy()
        for index, axis, by in moves:
            centres[index, axis] += by
        return extreme_runs.penetration(boxes, Poses(centres, still))

    assert found([]) == pytest.approx(0.0, abs=1e-12)
    assert found([(0, 2, -0.002)]) == pytest.approx(0.002), "into the floor"
    assert found([(4, 2, -0.003)]) == pytest.approx(0.003), "into the one below"
    assert found([(1, 0, -0.001), (3, 0, 0.004)]) == pytest.approx(0.001), "into the one beside"
    assert found([(7, 2, 0.004)]) == 0.0 or found([(7, 2, 0.004)]) == pytest.approx(0.0, abs=1e-12)


def test_energy_is_that_of_a_spinning_and_moving_box(engine):
    """v^2 / 2g, plus I w^2 / 2mg about the y axis with I = m (a^2 + c^2) / 12."""
    box = Box((0.1, 0.2, 0.3), 4.0, (0.0, 0.0, 5.0))
    with open_world(engine, WorldSettings()) as world:
        world.add_box(box)
        world.prepare()
        rest = extreme_runs.energy(world)
        world.set_velocities(Velocities(np.array([[2.0, 0, 0]]), np.array([[0, 3.0, 0]])))
        gained = extreme_runs.energy(world) - rest
    assert rest == pytest.approx(5.0)
    expected = (2.0**2 + (0.1**2 + 0.3**2) / 12 * 3.0**2) / (2 * GRAVITY)
    assert gained == pytest.approx(expected, rel=1e-6)


def test_a_box_slides_to_a_stop(engine):
    """v^2 / (2 mu g) = 0.102 m at friction 0.5, and 1 m in 1 s without."""
    found = measure_cell("sliding", engine, 240, 0.5)
    assert found.outcome.good
    assert found.numbers["expected"] == pytest.approx(1.0 / 9.8)
    assert found.numbers["found"] == pytest.approx(1.0 / 9.8, rel=0.1)
    free = measure_cell("sliding", engine, 240, 0)
    assert (free.outcome, free.numbers["expected"]) == (Outcome.CLOSE, 1.0)


@pytest.mark.parametrize("sweep", SWEEPS)
def test_an_easy_value_of_every_sweep_is_held(sweep):
    own = SWEEPS[sweep]
    cell = measure_cell(sweep, "mujoco", 480, own.shown or own.values[len(own.values) // 3])
    assert cell.outcome.good


def test_a_cube_bounces_to_the_square_of_the_restitution():
    found = measure_cell("bounce", "chipmunk", 480, 0.8)
    assert found.numbers["expected"] == pytest.approx(0.64)
    assert found.outcome.good
    assert found.numbers["found"] == pytest.approx(0.64, rel=0.05)
    asked = measure_cell("bounce", "reference", None, 0.8)
    assert (asked.outcome, asked.note) == (Outcome.UNDEFINED, "not defined: no restitution")
    grid = measure_cell("grid-restitution", "reference", None, 0.8)
    assert grid.outcome is Outcome.UNDEFINED
    assert measure_cell("grid-restitution", "reference", None, 0).outcome is Outcome.CLOSE


def test_limits_on_a_closed_form():
    said = [extreme_runs.compared(f, 10.0).outcome for f in (10.19, 9.81, 10.9, 9.1, 11.1, 8.9)]
    assert said == [Outcome.CLOSE] * 2 + [Outcome.HELD] * 2 + [Outcome.FAILED] * 2
    said = [extreme_runs.compared(f, 0.0, slack=0.01).outcome for f in (0.001, 0.009, 0.011)]
    assert said == [Outcome.CLOSE, Outcome.HELD, Outcome.FAILED]


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("count", [1, 8, 27, 200])
def test_a_pile_has_no_gaps_and_no_overlaps(count, dimensions):
    boxes = scenes.pile(count, dimensions)
    cells = {tuple(np.round(np.array(b.centre) / scenes.SIDE * 2).astype(int)) for b in boxes}
    assert len(cells) == len(boxes) == count
    if dimensions == 2:
        assert {y for _, y, _ in cells} == {0}
    # Every cube stands on the floor or on another.
    assert all(z == 1 or (x, y, z - 2) in cells for x, y, z in cells)
    assert max(z for *_, z in cells) // 2 < count ** (1 / dimensions) + 1


# --- what goes wrong is an outcome --------------------------------------------------------------


def test_time_runs_out_between_substeps():
    cell = measure_cell("tower", "bullet", 240, 2, timeout=1e-9)
    assert (cell.outcome, cell.note) == (
        Outcome.NO_VERDICT,
        "no verdict within 1e-09 s of CPU time",
    )
    assert set(cell.numbers) == {"cpu"}


@pytest.mark.parametrize(
    ("sweep", "value"), [("tower", 2), ("plate-on-edge", 5), ("sliding", 0.5), ("bounce", 0.5)]
)
def test_failures_are_cells(sweep, value, broken_bullet):
    cell = measure_cell(sweep, "bullet", 240, value)
    outcome = Outcome.FAILED if broken_bullet == "diverged" else Outcome.NO_VERDICT
    assert (cell.outcome, cell.note) == (outcome, broken_bullet)


# --- running ------------------------------------------------------------------------------------


def test_a_tower_is_given_up_after_three_failures(tmp_path):
    """At 5 Hz bullet holds no tower of 2, and not always a single cube."""
    seen = []
    cells = run_extremes(
        Lab(tmp_path, 0, lambda _, *at: seen.append(at)),
        engines=["bullet"],
        sweeps=["tower"],
        frequencies=[5, 240],
    )
    coarse = [c for c in cells if c.frequency == 5]
    assert len(list((tmp_path / "cells").iterdir())) == len(cells), "and not measured"
    good = [c.outcome.good for c in coarse]
    assert [c.value for c in coarse] == [1, 2, 3, 5][: len(good)]
    assert good in ([True, False, False, False], [False, False, False])
    assert len([c for c in cells if c.frequency == 240]) > 8
    most = 2 * len(SWEEPS["tower"].values)
    assert (seen[0], seen[-1]) == ((0, most), (most, most))


def test_a_second_run_measures_only_what_is_missing(tmp_path, monkeypatch):
    def run(**changes):
        asked = {"engines": ["bullet"], "sweeps": ["light-on-heavy", "tower"]}
        return run_extremes(Lab(tmp_path, 0), **{**asked, "frequencies": [10], **changes})

    first, measured = run(), []
    real = extreme_cells.measured
    monkeypatch.setattr(extreme_cells, "measured", lambda unit: measured.append(unit) or real(unit))
    assert run() == first
    assert not measured
    assert len(run(frequencies=[10, 15], sweeps=["light-on-heavy"])) == len(measured) * 2
    # One cell lost: it alone comes back.
    cells = {file: json.loads(file.read_text()) for file in (tmp_path / "cells").iterdir()}
    mine = ("light-on-heavy", 10)
    asked = [file for file, cell in cells.items() if (cell["sweep"], cell["frequency"]) == mine]
    file = sorted(asked)[3]
    file.unlink()
    lost = cells[file]
    measured.clear()
    again = run()
    assert [(u.frequency, u.value) for u in measured] == [(lost["frequency"], lost["value"])]
    assert [(c.sweep, c.value, c.outcome) for c in again] == [
        (c.sweep, c.value, c.outcome) for c in first
    ]
    monkeypatch.setattr(extreme_runs, "VERSION", 2)
    measured.clear()
    run()
    assert len(measured) == len(first), "a raised version asks anew"


@pytest.fixture
def hanging(tmp_path, monkeypatch):
    """An engine of another distribution whose steps hang, and hold Python's lock."""
    about = tmp_path / "site" / "hanging-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: hanging\nVersion: 1.0\n")
    entry = "[steadyload.engines]\nhanging = hanging_engine:HangingWorld\n"
    (about / "entry_points.txt").write_text(entry)
    (about.parent / "hanging_engine.py").write_text(
        "import re\n"
        "from steadyload.engines.with_bullet import BulletWorld\n"
        "class HangingWorld(BulletWorld):\n"
        "    def _advance(self, substeps, length):\n"
        "        re.match('(a|aa)+$', 99 * 'a' + 'b')\n"
    )
    monkeypatch.syspath_prepend(about.parent)
    path = os.pathsep.join([str(about.parent), *filter(None, sys.path)])
    monkeypatch.setenv("PYTHONPATH", path)
    registry._from_other_distributions.cache_clear()
    yield "hanging"
    registry._from_other_distributions.cache_clear()


def test_a_native_call_that_hangs_costs_one_cell(hanging, tmp_path):
    asked = {"engines": [hanging], "sweeps": ["light-on-heavy"], "frequencies": [60]}
    values = SWEEPS["light-on-heavy"].values[:1]
    with pytest.MonkeyPatch.context() as patched:
        one = dataclasses.replace(SWEEPS["light-on-heavy"], values=values)
        patched.setitem(SWEEPS, "light-on-heavy", one)
        patched.setattr(extreme_cells, "TIMEOUT", 0.1)
        patched.setattr(extreme_cells, "hard_seconds", lambda timeout: 20.0 * timeout)
        (cell,) = run_extremes(Lab(tmp_path / "run"), **asked)
    assert (cell.outcome, cell.note) == (
        Outcome.NO_VERDICT, "no answer within 2 s of CPU time; its process was killed",
    )  # fmt: skip


def test_an_engine_with_its_own_steps_runs_once(tmp_path):
    cells = run_extremes(
        Lab(tmp_path, 0),
        engines=["chipmunk", "reference"],
        sweeps=["plate-on-edge"],
        frequencies=[60, 240],
    )
    runs = list(dict.fromkeys((c.engine, c.frequency) for c in cells))
    assert runs == [("chipmunk", 60), ("chipmunk", 240), ("reference", None)]


# --- the envelope -------------------------------------------------------------------------------


def cells_of(engine, frequency, held):
    """Cells of all sweeps that an envelope needs; ``held`` says of each value whether it was."""
    return [
        ExtremeCell(name, engine, frequency, value, outcome)
        for name in ENVELOPE_SWEEPS
        for value in SWEEPS[name].values
        for outcome in [Outcome.HELD if held.get(name, lambda v: True)(value) else Outcome.FAILED]
    ]


def test_an_envelope_ends_where_the_first_value_was_not_held():
    held = {
        "tower": lambda n: n != 15,
        "heavy-on-light": lambda r: r <= 1e4,
        "heavy-on-two": lambda r: r <= 300,
        "light-on-heavy": lambda r: r < 1,
        "size-two": lambda cm: cm >= 1,
        "size-five": lambda cm: cm < 200,
        "items": lambda n: n <= 75,
        "plate-on-edge": lambda cm: cm != 5,
    }
    (row,) = envelope_rows(cells_of("bullet", 60, held))
    assert row == EnvelopeRow("bullet", 60, 10, 300.0, 0.0, 1.0, 100.0, 75, False)
    (none,) = envelope_rows(cells_of("bullet", 60, {"size-two": lambda cm: cm != 10}))
    assert (none.least_size, none.most_size) == (0.0, 0.0)
    (all_of_it,) = envelope_rows(cells_of("bullet", 60, {}))
    assert all_of_it == EnvelopeRow("bullet", 60, 100, 1e6, 1e6, 0.1, 1000.0, 200, True)
    strict = envelope_rows(cells_of("bullet", 60, {}), at_rest=True)
    assert strict[0].tower_height == 0
    assert envelope_rows(cells_of("bullet", 60, {})[5:]) != ()
    assert envelope_rows([c for c in cells_of("bullet", 60, {}) if c.sweep != "items"]) == ()


def test_from_a_frequency_on_is_what_all_higher_ones_hold():
    def row(frequency, tower, heavy, falls=True):
        return EnvelopeRow("bullet", frequency, tower, heavy, 1e6, 1.0, 1000.0, 200, falls)

    rows = (row(5, 100, 1e6, falls=False), row(30, 7, 30.0), row(60, 30, 10.0), row(90, 20, 10.0),
            row(240, 20, 100.0))  # fmt: skip
    found = [(r.frequency, r.tower_height, r.heavy_on_light) for r in from_here_on(rows)]
    assert found == [(30, 7, 10.0), (60, 20, 10.0), (240, 20, 100.0)]
    assert from_here_on((row(240, 1, 1.0),)) == ()
    own = EnvelopeRow("reference", None, 100, 1e6, 1e6, 0.1, 500.0, 100, True)
    assert from_here_on((*rows, own))[-1] == own


def test_the_file_is_read_back_and_keeps_other_engines(tmp_path, monkeypatch):
    made = {"git": "abc", "code": "def", "versions": {"pybullet": "3", "mujoco": "4", "numpy": "2"}}
    path = tmp_path / "envelopes.json"
    first = envelope_rows(cells_of("bullet", 60, {}))
    monkeypatch.setattr("steadyload.studies.extremes.envelopes.envelope_file", lambda: path)
    write_envelopes(first, first, made)
    other = envelope_rows(cells_of("mujoco", 60, {"tower": lambda n: n < 10}))
    still = envelope_rows(cells_of("mujoco", 60, {"tower": lambda n: n < 3}))
    write_envelopes(other, still, {**made, "git": "new"})
    read = json.loads(path.read_text())
    assert [read[name]["made"]["git"] for name in ("bullet", "mujoco")] == ["abc", "new"]
    held = Envelope(**read["mujoco"]["rows"][0]["holds"])
    assert (held.tower_height, held.least_size, held.sees_falls) == (7, 0.1, True)
    assert read["mujoco"]["rows"][0]["rests"]["tower_height"] == 2


# --- what is shown ------------------------------------------------------------------------------


NUMBERS = {"moved": 0.5, "found": 1.02, "expected": 1.0, "cpu": 3.0}


def outcome(sweep, frequency, value):
    """Nothing moves at 240 Hz; at 60 Hz the highest towers fall."""
    if frequency == 240:
        return Outcome.CLOSE
    return Outcome.FAILED if (sweep, frequency, value) == ("tower", 60, 100) else Outcome.HELD


@pytest.fixture(scope="module")
def cells():
    """All sweeps of an engine at two frequencies, and of one that chooses its steps; made up."""
    return [
        ExtremeCell(name, *run, value, outcome(name, run[1], value), NUMBERS)
        for name, sweep in SWEEPS.items()
        for run in (("bullet", 60), ("bullet", 240), ("reference", None))
        for value in sweep.values
    ]


@pytest.fixture(scope="module")
def found(cells):
    return shown(cells, provenance(), LOADS)


def test_the_page_shows_what_was_found(found, assert_shown):
    errors = [f"{one.sweep.name}-error" for one in found.formulas]
    assert_shown(
        Extremes(),
        found,
        answer=[240, 100, "1,000,000"],
        charts=[*SWEEPS, "closed-forms", "changed-loads", *errors],
        drawn=False,
    )


def test_what_was_held_is_counted_at_each_frequency_and_above(found, cells):
    assert {row.frequency: row.tower_height for row in found.envelope} == {
        60: 85,
        240: 100,
        None: 100,
    }
    assert {row.frequency: row.tower_height for row in found.rests} == {60: 0, 240: 100, None: 0}
    assert [row.frequency for row in found.from_here_on] == [60, 240, None]
    assert [row.frequency for row in found.at_rest] == [240]
    assert [(row.engine, row.frequency) for row in found.usually] == [
        ("bullet", 240), ("reference", None),
    ]  # fmt: skip
    third = len(cells) // 3
    assert list(found.counted.values()) == [third, 2 * third - 1, 1, 0, 0]
    assert found.silent == {}


def test_values_are_shown_with_those_of_the_closed_form(found):
    sliding, tower = found.formulas[0], found.resting[0]
    rows = sliding.found.drop(columns="rate").to_numpy().tolist()
    assert [(engine, {*found}) for engine, *found in rows] == [
        ("closed form", {1.0}), ("bullet", {1.02}), ("bullet", {1.02}), ("reference", {1.02}),
    ]  # fmt: skip
    assert {round(point.size, 9) for point in sliding.points} == {2.0}
    assert tower.largest[["rate", "largest"]].to_numpy().tolist() == [
        ["60 Hz", 85], ["240 Hz", 100], ["own", 100],
    ]  # fmt: skip


def test_who_ran_out_of_time_is_named(cells):
    late = [
        dataclasses.replace(c, outcome=Outcome.NO_VERDICT)
        if (c.sweep, c.engine, c.value, c.frequency) == ("items", "bullet", 200, 60)
        else c
        for c in cells
    ]
    found = shown(late, provenance(), LOADS)
    assert found.counted["without a verdict"] == 1
    assert found.silent == {"bullet, number of items": ["60 Hz"]}


def test_a_limit_is_of_frequencies_of_engines_with_fixed_steps(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        extreme_cells, "run_extremes", lambda lab, engines, **of: asked.append((engines, of)) or []
    )
    monkeypatch.setattr(loads, "loads_moved_and_scaled", lambda lab, limit: asked.append(limit))
    Extremes(limit=3).run(Lab(tmp_path, 0))
    Extremes().run(Lab(tmp_path, 0))
    (few, of), cases, (every, full), all_cases = asked
    assert {*every} - {*few} == {"reference"}
    assert (of["frequencies"], cases) == ((5, 10, 15), 3)
    assert (full["frequencies"], all_cases) == (FREQUENCIES, 100)
    with pytest.raises(ConfigError, match="leave --limit out"):
        Extremes(limit=1, write_envelope=True)


def test_envelopes_are_written_where_they_are_asked_for(found, tmp_path, monkeypatch):
    path = tmp_path / "envelopes.json"
    monkeypatch.setattr("steadyload.studies.extremes.envelopes.envelope_file", lambda: path)
    Extremes().beside(found, tmp_path)
    assert not path.exists()
    assert not list(Extremes().remarks(found))
    asked = Extremes(write_envelope=True)
    asked.beside(found, tmp_path)
    written = stored_object(path, "")
    assert {name: len(entry["rows"]) for name, entry in written.items()} == {
        "bullet": 2, "reference": 1,
    }  # fmt: skip
    assert list(asked.remarks(found)) == [f"envelopes: {path}"]


# --- what is committed --------------------------------------------------------------------------


@pytest.mark.engine("bullet")
def test_the_committed_envelope_is_the_published_one():
    text = (PUBLISHED / "report.md").read_text()
    [beside] = PUBLISHED.glob("report-details*.md")
    rows = re.findall(r"^\| (.*) \|$", beside.read_text(), flags=re.MULTILINE)
    cells = [tuple(cell.strip() for cell in row.split("|")) for row in rows]
    published = {row for row in cells if len(row) == 8 and row[-1] in ("yes", "no")}
    committed = set()
    for engine, rows in envelopes().items():
        for frequency, held in rows:
            numbers = (held.heavy_on_light, held.light_on_heavy)
            edges = f"{held.least_size:g} to {held.most_size:g}" if held.most_size else "none"
            committed.add((
                engine, "own" if frequency is None else f"{frequency} Hz",
                str(held.tower_height or "none"),
                *(f"{n:,.0f}" if n else "none" for n in numbers),
                edges, str(held.item_count or "none"), "yes" if held.sees_falls else "no",
            ))  # fmt: skip
    assert committed == published
    measured = set(envelopes())
    assert {"bullet", "mujoco", "dart", "chipmunk", "reference"} <= measured <= set(engines())
    assert [f for f, _ in envelopes()["bullet"]] == list(FREQUENCIES)
    source = re.search(r"- source: (?:git )?(\w+)", text)
    for entry in stored_object(envelope_file(), "").values():
        assert (entry["made"]["git"],) == source.groups()
