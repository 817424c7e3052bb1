"""Where ten measured tosses end in every engine stays what rows of ``reality`` were made with."""

import copy

import pytest
from tosses import COUNT, DATA, differences, ends, packages, read
from verdicts import machine

from steadyload.engines.registry import capabilities, engines
from steadyload.measured.derived import face_down
from steadyload.studies.reality.releasing import FACES
from steadyload.studies.reality.running import able_engines


@pytest.mark.exact("ends were recorded from planned starts")
def test_tosses_end_where_they_were_kept(any_engine):
    if capabilities(any_engine).dimensions == 2:
        pytest.skip("not applicable: two dimensions")
    if not DATA.exists():
        pytest.skip("the tosses are not beside the project (../shared/data)")
    everything = read()
    kept = everything["engines"][any_engine]
    if kept["packages"] != packages(any_engine):
        pytest.skip(f"not applicable: kept with {kept['packages']}")
    same_machine = everything["machine"] == machine()
    found = differences(kept["ends"], ends(any_engine), same_machine=same_machine)
    assert not found, (
        f"{len(found)} tosses end elsewhere in {any_engine}: mend the code, or raise VERSION in "
        "measured/simulating.py or of the engine and record anew: python tests/golden/record.py "
        f"--tosses\n" + "\n".join(found)
    )


def test_every_engine_that_takes_a_body_in_flight_is_kept():
    kept = read()["engines"]
    assert set(able_engines()) <= set(kept)
    assert {len(one["ends"]) for one in kept.values()} == {COUNT}


def test_half_of_the_ends_hold_on_any_kind_of_machine_and_all_lie_on_a_face():
    """Of Drake, which only checks others, none do: moved starts end millimetres away."""
    for name, one in read()["engines"].items():
        steady = sum(end["steady"] for end in one["ends"])
        assert steady >= COUNT // 2 or engines()[name].check_only, name
        faces = [face_down(end["attitude"]) for end in one["ends"]]
        assert {face.name for face in faces} <= set(FACES)
        assert max(face.tilt_deg for face in faces) < 3.0, name


@pytest.mark.parametrize(
    ("off", "steady", "same_machine", "expected"),
    [
        (1e-12, True, True, 1),
        (1e-12, True, False, 0),
        (0.01, True, False, 1),
        (0.01, False, False, 0),
        (0.01, False, True, 1),
    ],
)
def test_an_end_elsewhere_is_found_as_far_as_the_machine_allows(
    off, steady, same_machine, expected
):
    kept = [{**end, "steady": steady} for end in read()["engines"]["mujoco"]["ends"]]
    now = copy.deepcopy(kept)
    now[3]["centre"][0] += off
    assert len(differences(kept, now, same_machine=same_machine)) == expected
    now[3] = {**now[3], "centre": None, "attitude": None}
    assert len(differences(kept, now, same_machine=same_machine)) == (steady or same_machine)
