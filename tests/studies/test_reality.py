"""The study of recorded motion, on throws that an engine made: what it has to find is known."""

import csv
import io
import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from steadyload.engines.attitudes import rotate
from steadyload.engines.registry import capabilities
from steadyload.engines.world import Box, WorldSettings
from steadyload.measured.bodies import Body
from steadyload.measured.errors import MotionError
from steadyload.measured.flight import flight_frames
from steadyload.measured.motion_files import write_motion
from steadyload.measured.simulating import simulated
from steadyload.methods.registry import make_method
from steadyload.reports.table import percent, plain_percent
from steadyload.runs.kept_only import kept_only
from steadyload.statistics.estimate import Estimate
from steadyload.stored import StoredFileError
from steadyload.studies.kit import Lab
from steadyload.studies.reality import fitting, running
from steadyload.studies.reality.chances import (
    FACTORS,
    briers,
    chances,
    chosen_factor,
    log_losses,
    loss,
    probabilities,
)
from steadyload.studies.reality.comparing import compare
from steadyload.studies.reality.fitting import Fitted, closeness, nearest_genotype, search
from steadyload.studies.reality.loading import (
    changed,
    changes,
    differences,
    rankings,
)
from steadyload.studies.reality.record import (
    FIT,
    MEASURED,
    NOTE,
    halves,
    note_record,
    open_record,
)
from steadyload.studies.reality.releasing import (
    FACES,
    Jittered,
    Taken,
    by_flights,
    contact_of,
    is_slow,
)
from steadyload.studies.reality.running import Way, able_engines, measured
from steadyload.studies.reality.study import FILE, Reality
from steadyload.studies.reality.tosses import COLUMNS, as_csv
from steadyload.tuning.space import space_on

SIDE, MASS, FRICTION, OFFSET = 0.1, 0.4, 0.2, (0.0, 0.004, -0.006)
SIZE = (SIDE, SIDE, SIDE)
MOMENTS = (8e-4, 8e-4, 8e-4)
ENGINE = "rapier"
"""It hardly depends on where in a substep a cube strikes, as stiff contacts of others do."""


def thrown(seed, engine=ENGINE, friction=FRICTION):
    """A throw by an engine, as it would be recorded: a cube with its centre of mass off."""
    random = np.random.default_rng(seed)
    attitude = tuple(Rotation.random(random_state=seed).as_quat(scalar_first=True).tolist())
    box = Box(
        SIZE, MASS, (0.0, 0.0, 0.25), OFFSET, attitude=attitude,
        velocity=(*random.uniform(-1.0, 1.0, 2).tolist(), 0.3),
        angular_velocity=tuple(random.uniform(-6.0, 6.0, 3).tolist()), moments=MOMENTS,
    )  # fmt: skip
    settings_ = WorldSettings(friction=friction)
    found = simulated(f"t{seed}", box, engine, settings_, 480, np.arange(90) / 148.0)
    body = Body(size=SIZE, mass=MASS, inertia=MOMENTS, friction=friction, restitution=0.0)
    return replace(found, body=body)


@pytest.fixture(scope="module")
def throws():
    return [thrown(seed) for seed in range(12)]


@pytest.fixture(scope="module")
def data(throws, tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "throws.parquet"
    write_motion(path, throws)
    return path


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return Lab(tmp_path_factory.mktemp("reality"), 0)


@pytest.fixture(scope="module", autouse=True)
def small_searches():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fitting, "SEEDS", (0,))
        patch.setattr(fitting, "POPULATION", 6)
        patch.setattr(fitting, "GENERATIONS", 2)
        patch.setattr(running, "JITTERS", 3)
        patch.setattr(running, "LAYOUTS", 4)
        patch.setattr(running, "able_engines", lambda: ("bullet", ENGINE))
        yield


@pytest.fixture(scope="module")
def all_measured(lab, data):
    return measured(lab, data)


def test_an_engine_that_made_the_record_is_fitted_to_it_and_finds_it_again(all_measured, throws):
    other, one = all_measured.engines
    assert (other.name, one.name) == ("bullet", ENGINE), "in the order of the registry"
    assert one.fitted.parameters["friction"] == pytest.approx(FRICTION, abs=0.011)
    assert one.fitted.closeness > max(0.5, other.fitted.closeness)
    flight = all_measured.recorded.fitted_flight
    assert flight.offset == pytest.approx(OFFSET, abs=5e-4)
    assert all_measured.taken.offset == pytest.approx(OFFSET, abs=5e-4)
    assert all_measured.taken.scale == pytest.approx(1.0, abs=2e-3)
    ends = one.batches[Way.FITTED].ended
    assert [end.name for end in ends] == [trial.name for trial in throws]
    assert sum(end.same_face for end in ends) >= 10
    assert np.median([end.off_m for end in ends]) < 0.012
    centred = one.batches[Way.IDENTIFIED].ended
    assert np.median([end.off_m for end in centred]) > np.median([end.off_m for end in ends])
    for end in ends:
        assert not end.failed
        assert end.since_contact[0] < 1e-3
        assert end.through_impacts[0] < 2e-3


def test_what_is_searched_holds_the_closest_set(all_measured):
    for one in all_measured.engines:
        fitted = one.fitted
        assert fitted.tried[0].parameters == fitted.parameters
        sizes = [tried.closeness for tried in fitted.tried]
        assert sizes == sorted(sizes, reverse=True)
        parameters = make_method(fitted.spec).parameters
        for name, value in fitted.parameters.items():
            assert getattr(parameters, name) == value
            assert fitted.least[name] <= fitted.most[name]
        assert contact_of(fitted.spec).settings.friction == fitted.parameters["friction"]


def test_ways_take_contacts_and_the_body_from_their_sources(all_measured):
    one = all_measured.engines[1]
    assert {*one.batches} == {*Way}
    steps = one.steps
    assert [*steps] == [
        "first frame, uniform density", "all frames of the flight",
        "moments of inertia as stated", "centre of mass by flights", "lengths by flights",
    ]  # fmt: skip
    assert steps["moments of inertia as stated"] == one.batches[Way.IDENTIFIED]
    assert one.preset == f"ps_opt@{ENGINE}"
    far = [np.median([end.off_m for end in one.ended]) for one in steps.values()]
    assert far[-1] < far[0], "what is known of the body brings simulations nearer to it"


def comparable(found):
    """The same with the accuracies of evaluations in their place: these hold frames."""
    return replace(
        found,
        engines=[
            replace(one, evaluation=one.evaluation and [
                (row.method, row.accuracy) for row in one.evaluation.methods
            ])
            for one in found.engines
        ],
    )  # fmt: skip


def test_rows_are_enough_without_the_record_and_nothing_is_simulated(
    lab, data, all_measured, monkeypatch
):
    with kept_only("none is measured"):
        again = measured(lab)
    assert comparable(again) == comparable(all_measured)
    monkeypatch.setattr(running, "JITTERS", 2)
    with pytest.raises(MotionError, match="the record is not here; allowed: --data FILE"):
        measured(lab)


def test_slow_engines_are_run_where_they_are_asked_for(lab, data, all_measured, monkeypatch):
    monkeypatch.setattr(running, "able_engines", lambda: (ENGINE, "reference"))
    without = measured(lab, data)
    assert [one.name for one in without.engines] == [ENGINE]
    assert without.missing == ["reference"]
    with pytest.MonkeyPatch.context() as alone:
        alone.setattr(running, "able_engines", lambda: ("reference",))
        with pytest.raises(MotionError, match="no rows of reference; allowed: --reference"):
            measured(lab, data)
    done = []

    def interrupted(unit):
        if len(done) == 1:
            raise KeyboardInterrupt
        done.append(unit.taken)
        return all_measured.engines[0].batches[Way.FITTED]

    fit = all_measured.engines[0].fitted
    stiff = {"friction": 0.2, "stiffness": 1e9, "damping_time": 3e-3}
    spec = "simulation@reference:friction=0.2,frequency=480,stiffness=1e9,damping_time=3e-3"
    own = replace(fit, spec=spec, parameters=stiff, least=stiff, most=stiff, tried=[])
    monkeypatch.setattr(fitting.FitUnit, "measure", lambda unit: own)
    monkeypatch.setattr(running.ReleasedUnit, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        measured(lab, data, reference=True)
    assert len(done) == 1
    assert measured(lab, data).missing == ["reference"], "not complete"
    done.append("now all")
    found = measured(lab, data, reference=True)
    slow = next(one for one in found.engines if one.name == "reference")
    assert (slow.name, slow.slow, slow.jittered, slow.steps) == ("reference", True, {}, {})
    assert slow.preset == slow.label == "label@reference"
    with kept_only("none is measured"):
        assert comparable(measured(lab)) == comparable(found)


def test_engines_are_those_that_take_a_body_in_flight_in_space():
    names = able_engines()
    assert {"mujoco", "bullet", "dart", "reference"} <= {*names}
    assert "chipmunk" not in names
    assert [name for name in names if name in ("mujoco", "reference") and is_slow(name)] == [
        "reference"
    ]


# --- records that are refused -------------------------------------------------------------------


def written(folder, trials):
    write_motion(folder / "some.parquet", trials)
    return folder / "some.parquet"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t[:7], "holds 7 trials; allowed: 8 or more"),
        (
            lambda t: [replace(t[0], body=Body(size=SIZE)), *t[1:]],
            "trial 't0': size or mass are not known; allowed: both, as columns or as constants",
        ),
        (
            lambda t: [*t[:-1], replace(t[-1], body=replace(t[-1].body, mass=0.5))],
            "trial 't11': its body is not that of trial 't0'; allowed: one body in all trials",
        ),
        (lambda t: [*t[:3], shortened(t[3], 0, 40), *t[4:]], "trial 't3': moves in the end; allow"),
        (
            lambda t: [*t[:3], shortened(t[3], 60, None), *t[4:]],
            "trial 't3': flies freely for 0 frames; allowed: 3 or more from the first one on",
        ),
    ],
)
def test_a_record_that_cannot_be_compared_is_refused(throws, tmp_path, change, message):
    path = written(tmp_path, change(list(throws)))
    with pytest.raises(MotionError) as caught:
        open_record(tmp_path / "work", path, None)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert not (tmp_path / "work").exists()


def as_of_a_point_outside(trial):
    """In flight, positions are those of a point of the body 6 cm off its middle."""
    count, positions = flight_frames(trial), trial.positions.copy()
    positions[:count] += rotate(trial.attitudes[:count], np.tile((0.0, 0.06, 0.0), (count, 1)))
    return replace(trial, positions=positions, velocities=None)


def in_slower_time(trial):
    return replace(trial, times=3.0 * trial.times, velocities=None, spins=None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (in_slower_time, "bodies fall at 1.09 m/s2 in free flight; allowed: 4.9 to 19.6"),
        (as_of_a_point_outside, "by free flight the centre of mass is at ("),
    ],
)
def test_a_record_whose_flights_are_of_no_body_is_refused(throws, tmp_path, change, message):
    """Before an engine sees it; the record that was compared before stays the noted one."""
    good, lab = written(tmp_path, throws), Lab(tmp_path / "work", 0)
    note_record(lab.work, open_record(lab.work, good, None))
    noted = (lab.work / NOTE).read_bytes()
    bad = tmp_path / "bad.parquet"
    write_motion(bad, [change(trial) for trial in throws])
    with pytest.raises(MotionError) as caught:
        measured(lab, bad)
    assert str(caught.value).startswith(f"{bad}: {message}")
    assert (lab.work / NOTE).read_bytes() == noted


def shortened(trial, first, last):
    cut = slice(first, last)
    return replace(
        trial, times=trial.times[cut], positions=trial.positions[cut],
        attitudes=trial.attitudes[cut], velocities=trial.velocities[cut], spins=trial.spins[cut],
    )  # fmt: skip


def test_without_a_file_the_record_is_that_of_the_rows(data, tmp_path):
    with pytest.raises(MotionError, match="no record was compared here yet; allowed: --data FILE"):
        open_record(tmp_path, None, None)
    whole = open_record(tmp_path, data, None)
    note_record(tmp_path, whole)
    assert open_record(tmp_path, None, None).digest == whole.digest
    less = open_record(tmp_path, data, None, 9)
    assert len(less.trials) == 9
    assert open_record(tmp_path, None, None).digest == whole.digest
    note_record(tmp_path, less)
    assert open_record(tmp_path, None, None).digest == less.digest != whole.digest
    note = json.loads((tmp_path / NOTE).read_text())
    for damaged in ({**note, "digest": "0"}, {}, {"digest": None}):
        (tmp_path / NOTE).write_text(json.dumps(damaged))
        with pytest.raises(StoredFileError, match="damaged; name the record again by --data FILE"):
            open_record(tmp_path, None, None)


def test_a_record_is_another_one_by_each_of_its_parts(throws, tmp_path):
    def digest(trials, profile=None):
        return open_record(tmp_path, written(tmp_path, trials), profile).digest

    first, *others = throws
    moved = first.positions + np.array((0.0, 0.0, 1e-6))
    noisy = tmp_path / "noisy.toml"
    noisy.write_text("[noise]\nspin_rads = 0.2\n")
    digests = {
        digest(throws),
        digest(throws[:-1]),
        digest([replace(first, name="other"), *others]),
        digest([replace(first, positions=moved), *others]),
        digest([replace(first, velocities=None), *others]),
        digest([replace(one, body=replace(one.body, friction=0.3)) for one in throws]),
        digest(throws, noisy),
    }
    assert len(digests) == 7
    assert digest(throws) in digests


@settings(max_examples=50, deadline=None)
@given(st.integers(8, 400), st.integers(0, 10**6))
def test_halves_are_drawn_by_a_seed(count, seed):
    names = [f"n{k}" for k in range(count)]
    own = halves(names, seed)
    assert own == halves(names, seed)
    assert [*own] == names
    assert list(own.values()).count(FIT) - list(own.values()).count(MEASURED) == count % 2
    if count > 60:
        assert own != halves(names, seed + 1)


# --- contacts that are fitted -------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["mujoco", "bullet", "reference"])
@pytest.mark.parametrize(("seed", "seeds"), [(0, (0, 1)), (1, (0,)), (2, ())])
def test_a_search_ends_where_no_neighbour_is_closer(engine, seed, seeds):
    """Of a hill with one top it finds the top, wherever that is."""
    space = space_on(engine, fitting.SPACE)
    random = np.random.default_rng(seed)
    top = [int(random.integers(len(gene.values))) for gene in space.genes]
    asked = []

    def judge(genotype):
        asked.append(genotype)
        aside = sum(abs(at - best) for at, best in zip(genotype, top, strict=True))
        return [1.0 / (1.0 + aside)] * 3

    found = search(space, space.start, judge, seeds)
    assert max(found, key=lambda genotype: found[genotype][0]) == tuple(top)
    assert len(asked) == len({*asked}) == len(found), "none is judged twice"
    assert space.start in found


def test_a_search_begins_with_the_nearest_values():
    space = space_on("bullet", fitting.SPACE)
    found = space.values(nearest_genotype(space, {"friction": 0.184, "restitution": 0.9, "x": 1}))
    assert found == {"friction": 0.18, "restitution": 0.3}


@pytest.mark.parametrize(
    ("off_m", "turn_deg", "expected"),
    [(0.0, 0.0, 1.0), (0.02, 10.0, 0.5), (0.02, 0.0, 0.75), (math.inf, math.inf, 0.0),
     (0.06, 0.0, 0.625)],
)  # fmt: skip
def test_closeness_is_bounded(off_m, turn_deg, expected):
    assert closeness(off_m, turn_deg) == pytest.approx(expected)


def test_intervals_of_fitted_values_are_of_resampled_trials():
    """Two sets of which each suits half of the trials: any resample may prefer either."""
    space = space_on("bullet", fitting.SPACE)
    one = space.with_values(space.start, {"friction": 0.15})
    other = space.with_values(space.start, {"friction": 0.25})
    least, most = fitting._intervals(space, {one: [1.0, 0.0] * 20, other: [0.0, 1.0] * 20})
    assert (least["friction"], most["friction"]) == (0.15, 0.25)
    least, most = fitting._intervals(space, {one: [1.0, 0.9] * 20, other: [0.0, 0.2] * 20})
    assert (least["friction"], most["friction"]) == (0.15, 0.15)


# --- chances ------------------------------------------------------------------------------------


def test_chances_are_of_counts_with_a_release_spread_over_the_faces():
    found = probabilities([[24, 0, 0, 0, 0, 0], [12, 12, 0, 0, 0, 0], [0] * 6])
    assert found.sum(axis=1) == pytest.approx(1.0)
    assert found[0, 0] == pytest.approx((24 + 1 / 6) / 25)
    assert found[0, 1] == pytest.approx(1 / 150)
    assert found[1, :2] == pytest.approx([(12 + 1 / 6) / 25] * 2)
    assert found[2] == pytest.approx([1 / 6] * 6)


def test_log_loss_and_brier_are_those_of_their_definitions():
    given_ = np.array([[0.5, 0.5, 0, 0, 0, 0], [0.1, 0, 0, 0, 0.9, 0]])
    assert log_losses(given_, ["-x", "-z"]) == pytest.approx([math.log(2), -math.log(0.9)])
    assert briers(given_, ["-x", "-z"]) == pytest.approx([0.5, 0.02])
    assert briers(given_, ["+z", "-x"]) == pytest.approx([1.5, 0.81 + 0.81])
    # One that says nothing: every face has a sixth.
    blank = np.full((3, 6), 1 / 6)
    assert log_losses(blank, ["-x", "+y", "+z"]) == pytest.approx([math.log(6)] * 3)
    assert briers(blank, ["-x", "+y", "+z"]) == pytest.approx([5 / 6] * 3)


def test_a_factor_is_chosen_by_its_loss_then_by_nearness_to_the_noise():
    assert chosen_factor({0.5: 0.7, 1.0: 0.6, 2.0: 0.65}) == 1.0
    assert chosen_factor({0.25: 0.6, 0.5: 0.6, 3.0: 0.6}) == 0.5


def test_the_likeliest_face_and_its_chance_are_counted():
    found = Jittered(["a", "b", "c"], [[4, 0, 0, 0, 0, 0], [0, 3, 1, 0, 0, 0], [0] * 6], 2.0)
    faces = {"a": "-x", "b": "-y", "c": "-x"}
    row = chances(found, faces)
    assert row["trials"] == 3
    assert row["likeliest_face"].value == pytest.approx(
        2 / 3
    )  # of no release at all the first face
    assert row["its_chance"].value == pytest.approx((25 / 6 / 5 + 19 / 6 / 5 + 1 / 6) / 3)
    losses = [-math.log(25 / 30), -math.log(7 / 30), math.log(6)]
    assert row["log_loss"].value == loss(found, faces) == pytest.approx(np.mean(losses))


def test_every_engine_is_jittered_alike_and_more_by_larger_factors(all_measured):
    for one in all_measured.engines:
        halves_ = {half for half, _ in one.jittered}
        assert halves_ == {FIT, MEASURED}
        for found in one.jittered.values():
            assert {sum(counts) for counts in found.counts} == {running.JITTERS}
        most = [
            np.mean([max(counts) for counts in one.jittered[FIT, factor].counts])
            for factor in (FACTORS[0], FACTORS[-1])
        ]
        assert most[0] >= most[1]


# --- loading ------------------------------------------------------------------------------------


def fitted_as(**values):
    least = {name: 0.9 * value for name, value in values.items()}
    most = {name: 1.1 * value for name, value in values.items()}
    return Fitted("simulation@mujoco", values, least, most, 0.5, [], 1.0)


def test_fitted_values_stand_beside_those_of_loading():
    rows = differences(
        "E", "ps_opt@rapier", "label@rapier", fitted_as(friction=0.5, contact_frequency=60.0)
    )
    assert [(one["parameter"], one["label_value"], one["fitted_value"]) for one in rows] == [
        ("friction", 0.5, 0.5), ("contact_frequency", 120.0, 60.0),
    ]  # fmt: skip
    assert [one["differs"] for one in rows] == [False, True]
    (friction, stiffness) = differences(
        "E", "label@reference", "label@reference", fitted_as(friction=0.2, stiffness=1e7)
    )
    assert (stiffness["preset_value"], stiffness["differs"], friction["differs"]) == (
        1e9,
        True,
        True,
    )


@pytest.mark.parametrize(
    ("preset", "values", "specs"),
    [
        (
            "ps_opt@bullet",
            {"friction": 0.2, "restitution": 0.1},
            {
                "friction": "ps_opt@bullet:friction=0.2",
                "bounce and hardness": "ps_opt@bullet:restitution=0.1",
                "both": "ps_opt@bullet:friction=0.2,restitution=0.1",
            },
        ),
        (
            "ps_opt@mujoco:question=stands",
            {"friction": 0.2},
            {"friction": "ps_opt@mujoco:question=stands,friction=0.2"},
        ),
    ],
)
def test_a_preset_takes_fitted_values(preset, values, specs):
    assert changes(preset, fitted_as(**values)) == specs
    for spec in specs.values():
        parameters = make_method(spec).parameters
        assert any(getattr(parameters, name) == value for name, value in values.items())


def test_verdicts_that_change_are_counted_where_both_have_one():
    preset, other = "ps_opt@mujoco", "ps_opt@mujoco:friction=0.2"
    cases = pd.MultiIndex.from_tuples([(f"l{k}", "S1") for k in range(5)])
    said = pd.DataFrame(
        {preset: [5, 4, 3, 2, pd.NA], other: [5, 2, 4, 1, 1]}, index=cases, dtype="Int32"
    )
    clusters = pd.Series([*"abcde"], index=cases)
    accuracy = {preset: Estimate(0.8, 0.7, 0.9, 5), other: Estimate(0.6, 0.5, 0.7, 5)}
    evaluation = SimpleNamespace(
        judged=SimpleNamespace(said=said, clusters=clusters),
        row=lambda spec: SimpleNamespace(accuracy=accuracy[spec]),
    )
    (row,) = changed("E", preset, fitted_as(friction=0.2), evaluation, {})
    assert row["layouts"] == 4
    assert (row["verdict_changed"].value, row["fails_earlier"].value) == (0.75, 0.5)
    assert (row["before"].value, row["after"].value, row["as_reference"]) == (0.8, 0.6, None)
    by_reference = pd.Series([5, 2, 3, pd.NA, 0], index=cases, dtype="Int32")
    (row,) = changed("E", preset, fitted_as(friction=0.2), evaluation, {"friction": by_reference})
    assert (row["as_reference"].value, row["as_reference"].n) == (0.5, 4), (
        "of those of the reference"
    )


def row_of(engine, changed_, before, agrees=None, after=0.5, change="friction"):
    estimates = (Estimate(value, value, value, 9) for value in (changed_, 0.1, before, after))
    names = ("verdict_changed", "fails_earlier", "before", "after")
    with_reference = None if agrees is None else Estimate(agrees, agrees, agrees, 9)
    shares = dict(zip(names, estimates, strict=True))
    return {
        "engine": engine,
        "change": change,
        "layouts": 9,
        **shares,
        "as_reference": with_reference,
    }


def test_engines_are_ranked_before_and_after_without_the_reference():
    rows = [
        row_of("A", 0.3, 0.9, 0.7), row_of("B", 0.1, 0.8, 0.8), row_of("C", 0.2, 0.7, 0.6),
        row_of("R", 0.05, 1.0, 1.0), row_of("A", 0.0, 0.9, 0.9, change="both"),
    ]  # fmt: skip
    (found,) = rankings(pd.DataFrame(rows), "R")
    assert (found["change"], found["layouts"], found["labels"].value) == ("friction", 9, 0.05)
    assert (found["changed"].lowest, found["changed"].highest) == ("B", "A")
    assert (found["before"].highest, found["before"].lowest) == ("A", "C")
    assert (found["then"].highest, found["then"].lowest) == ("B", "C")
    assert (found["then"].most.value, found["then"].least.value) == (0.8, 0.6)
    assert (found["pairs"], found["turned"], found["clearly"]) == (3, 1, 1)
    # Without the reference the order is by the labels as they are.
    alone = [row_of("A", 0.3, 0.9, after=0.6), row_of("B", 0.1, 0.8, after=0.5)]
    (found,) = rankings(pd.DataFrame(alone), "")
    assert (found["labels"], found["then"].highest, found["turned"]) == (None, "A", 0)
    # An order that changes within the intervals is not clear.
    wide = pd.DataFrame([row_of("A", 0.3, 0.9, 0.7), row_of("B", 0.1, 0.8, 0.8)])
    wide["as_reference"] = [replace(one, low=0.6, high=0.9) for one in wide["as_reference"]]
    assert [(one["turned"], one["clearly"]) for one in rankings(wide, "")] == [(1, 0)]


def test_layouts_are_judged_with_fitted_contacts(all_measured, assert_shown):
    found = compare(all_measured)
    assert [one["change"] for one in found.rankings] == ["friction", "bounce and hardness", "both"]
    assert set(found.changed["change"]) == {one["change"] for one in found.rankings}
    assert {*found.changed["layouts"], *(one["layouts"] for one in found.rankings)} == {4}
    text = assert_shown(Reality(), found, charts=CHARTS, drawn=False)
    assert "pairs of engines change their order" in " ".join(text.split())


# --- the page -----------------------------------------------------------------------------------


CHARTS = ["faces", "friction", "time", "impacts", "factors", "reliability"]


def test_the_page_shows_what_was_found(all_measured, tmp_path, assert_shown):
    found = compare(all_measured)
    assert (found.best, found.measured_trials) == (capabilities(ENGINE).title, 6)
    best = next(one for one in found.fitted if one["engine"] == found.best)
    own = [toss for toss in all_measured.recorded.tosses if toss.half == MEASURED]
    right = np.mean([toss.as_released.same_face for toss in own])
    assert found.released["right_face"].value == pytest.approx(right)
    off = [one["off_cm"].value for one in (found.released, found.landed, best)]
    assert off[0] > off[1] > off[2]
    study = Reality()
    shares = sorted((one["right_face"] for one in found.fitted), key=lambda share: share.value)
    answer = [percent(shares[-1]), plain_percent(shares[0].value)]
    assert_shown(study, found, answer=answer, charts=CHARTS)
    study.beside(found, tmp_path)
    lines = list(csv.DictReader(io.StringIO((tmp_path / FILE).read_text())))
    assert tuple(lines[0]) == COLUMNS
    assert len(lines) == 2 * len(all_measured.recorded.tosses)
    first, end = lines[0], all_measured.engines[0].batches[Way.FITTED].ended[0]
    assert (first["trial"], first["engine"], first["face"]) == ("t0", "bullet", end.face)
    assert float(first["off_cm"]) == pytest.approx(100.0 * end.off_m, rel=1e-3)


def test_errors_are_medians_shares_and_failures_of_the_ends(all_measured):
    found = compare(all_measured)
    one = all_measured.engines[1]
    own = {toss.name for toss in all_measured.recorded.tosses if toss.half == MEASURED}
    ends = [end for end in one.batches[Way.FITTED].ended if end.name in own]
    row = next(each for each in found.fitted if each["name"] == ENGINE)
    assert row["right_face"].value == pytest.approx(np.mean([end.same_face for end in ends]))
    assert row["off_cm"].value == pytest.approx(100 * np.median([end.off_m for end in ends]))
    assert row["turn_deg"].value == pytest.approx(np.median([end.turn_deg for end in ends]))
    cost = found.costs.set_index("engine").loc[one.title]
    assert cost["tried"] == len(one.fitted.tried)
    expected = 1e3 * one.fitted.cpu_s / (cost["tried"] * 6)
    assert cost["throw_cpu"] == row["throw_cpu"] == pytest.approx(expected)
    assert found.by_time[0]["at"] == 0.0
    assert found.by_time[0]["off_cm"].value < 0.2
    assert list(dict.fromkeys(each["at"] for each in found.by_impacts))[:2] == [0, 1]


def failing(all_measured):
    """The same, but the first engine fails on every trial and is not jittered."""
    one, other = all_measured.engines
    lost = {
        "face": "", "same_face": False, "off_m": None, "turn_deg": None, "height_m": None,
        "deepest_m": None, "rest_s": None, "since_contact": [], "through_impacts": [],
        "failed": "the integrator gave up",
    }  # fmt: skip
    batch = one.batches[Way.FITTED]
    none = replace(batch, ended=[replace(end, **lost) for end in batch.ended])
    ways = {**one.batches, Way.FITTED: none}
    return replace(all_measured, engines=[replace(one, batches=ways, jittered={}), other])


def test_an_engine_that_fails_is_wrong_everywhere_and_has_a_page(all_measured, assert_shown):
    found = compare(failing(all_measured))
    row = found.fitted[0]
    assert (row["right_face"].value, row["off_cm"].value) == (0.0, math.inf)
    assert found.rests["no_end"][0] == len(all_measured.recorded.tosses)
    assert all("none" in one["predicted"] for one in found.worst.to_dict("records"))
    assert "the integrator gave up" in as_csv(found.measured)
    assert_shown(Reality(), found, charts=CHARTS, drawn=False)


def test_a_record_on_which_every_engine_fails_has_a_page(all_measured, assert_shown):
    one, _ = failing(all_measured).engines
    found = compare(replace(all_measured, engines=[one]))
    assert not found.by_time
    assert not found.by_impacts
    left = [chart for chart in CHARTS if chart not in ("time", "impacts", "factors", "reliability")]
    assert_shown(Reality(), found, charts=left, drawn=False)


def test_a_record_that_states_no_contact_has_a_page(all_measured, assert_shown):
    bare = replace(all_measured.recorded, friction=None, restitution=None, body="", source="")
    engines = [
        replace(
            one, steps={}, jittered={},
            batches={way: b for way, b in one.batches.items() if way is not Way.IDENTIFIED},
        )
        for one in all_measured.engines
    ]  # fmt: skip
    found = compare(replace(all_measured, recorded=bare, engines=engines, missing=["Drake"]))
    assert (found.surest, len(found.steps)) == (None, 0)
    charts = [name for name in CHARTS if name not in ("factors", "reliability")]
    text = assert_shown(Reality(), found, charts=charts, drawn=False)
    assert "not stated" in text
    assert "Drake" in text


def test_flights_give_the_body_to_engines_to_a_hundredth_of_a_millimetre(all_measured):
    flight = all_measured.recorded.fitted_flight
    taken = by_flights(flight)
    assert taken.offset == tuple(round(part, 5) for part in flight.offset)
    assert by_flights(flight, in_true_lengths=False) == Taken(offset=taken.offset)


def test_faces_are_all_faces():
    assert sorted(FACES) == sorted(f"{sign}{axis}" for sign in "+-" for axis in "xyz")
