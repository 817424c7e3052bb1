"""Labels, opinions, tuned values, thresholds and fronts of the package, by question.

Stored verdicts depend on these values, whatever form the files have. Who changes one on purpose
writes the digest that the test names.
"""

import hashlib
import json
from dataclasses import asdict

import pytest

from steadyload.app.recommend.kept import load_fronts
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import SETS
from steadyload.layouts.model.question import Question
from steadyload.methods.cascade.thresholds import ThresholdsError, load_thresholds
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import ABOUT, tuned
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.labels import labelled_material
from steadyload.tuning.cases import CaseSource, fingerprint, load_cases

ENGINES = ("bullet", "chipmunk", "dart", "mujoco", "physx", "rapier")


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def of_frame(frame):
    return digest(frame.to_csv(index=False))


def of_values(values):
    return digest(json.dumps(values, sort_keys=True, default=str))


def of_set(word):
    """Digests of a set's labels, opinions, confidence and chosen cases, by question."""
    benchmark, found = load_benchmark(word), {}
    for question in Question:
        labels, opinions = benchmark.labels_on(question), benchmark.further_verdicts_on(question)
        found[question] = (
            of_frame(labels[[*KEYS, "status", "failing_step"]]),
            of_frame(opinions[[*KEYS, "reason", "judge", "status", "failing_step"]]),
            of_frame(benchmark.confidence_on(question).reset_index()),
        )
        if len(labels):
            chosen = benchmark.select(question=question)
            found[question] += (of_frame(chosen[[*KEYS, "rank", "failing_step"]]),)
    return {str(question): " ".join(found[question]) for question in Question}


def of_tuned():
    """Digests of tuned parameters and their provenance, by preset and question."""
    return {
        f"{preset} {question}": of_values(
            {
                engine: [dict(found.parameters), dict(found.made_by)]
                for engine, found in tuned(question, preset).items()
            }
        )
        for preset in ABOUT
        for question in Question
    }


def of_thresholds():
    """Digests of thresholds, by engine and question, and what keys hold of their cascade."""
    found = {}
    for question in Question:
        for engine in ENGINES:
            try:
                values = asdict(load_thresholds(engine, question=question))
            except ThresholdsError:
                continue
            values["ladders"] = {str(k): v for k, v in values["ladders"].items()}
            made_of = make_method(f"cascade@{engine}:question={question}").made_of()
            found[f"{engine} {question}"] = f"{of_values(values)} {made_of[:16]}"
    return found


def of_fronts():
    """Digests of the fronts that come with the package, by question."""
    fronts = load_fronts()
    return {
        str(question): of_values([asdict(one) for one in fronts if one.question == question])
        for question in Question
    }


def of_keys():
    """Digests of cases that keys of runs and of searches hold."""
    study = StudyDefinition("pin", ("fbs",), benchmark="all", limit=20)
    runs = {
        str(word): labelled_material(study, load_benchmark(word)).about["hash"]
        for word in (None, *SETS)
    }
    searched = {
        str(question): fingerprint(
            load_cases(CaseSource("search", "choosing", 10, question, ("real",)))
        )
        for question in Question
    }
    return {f"run on {word}": value for word, value in runs.items()} | searched


FOUND = {
    **{f"set {word}": (lambda word=word: of_set(word)) for word in (None, *SETS)},
    "tuned": of_tuned,
    "thresholds": of_thresholds,
    "fronts": of_fronts,
    "keys": of_keys,
}

EXPECTED = {
    "set None": {
        "within": "35d3ee9c25aaa0a4 01953815fa6e3991 9b6d4774d76edfb6 6fba09e84ced5aaf",
        "stands": "d9af3b83e3d43422 05599856ff204e00 dc07259abc3cb9ca 2ea1b66efaea61fc",
    },
    "set planar": {
        "within": "b23bdb6f3f395eb0 374d511e3153f489 b9833da7ed1b04e0 8041f86a640f917a",
        "stands": "534c13987771d0cd 05599856ff204e00 dc07259abc3cb9ca",
    },
    "set real": {
        "within": "83c7dd0784cf752f 821df22a5ec1b2df fc5a74698701fd8c f0dbf532e598ff92",
        "stands": "a7fc5820a05dc784 461f4f3811bcbc5d 7daf66c2b4eff0c5 02024f9ab8612515",
    },
    "set lists": {
        "within": "f1ebb4e3682a0a51 3842444d446ce328 eae65bb62f30938c 8579945266b46553",
        "stands": "78a118be89bbaa0e ae262fa5ebe1c5f5 df202c4f88eb5619 4c9aca4ee63d0cc6",
    },
    "set choosing": {
        "within": "5a36e43ccfea2b63 29919c96173d9a67 834898553f85107f f3ce5f39b4927401",
        "stands": "e5ddef33db4241c1 05599856ff204e00 dc07259abc3cb9ca 4cb48bc86947eced",
    },
    "tuned": {
        "ps_opt within": "d95ebc96ab432122",
        "ps_opt stands": "724ed4480cc157e6",
        "ps_opt-equal within": "22efe7019f215284",
        "ps_opt-equal stands": "44136fa355b3678a",
    },
    "thresholds": {
        "bullet within": "e83da5932f55b300 118f430ce37c4cd4",
        "mujoco within": "8c8088b3f6bed8d9 6db8eed0e1a95702",
        "rapier within": "dbcf7ac81cfe3e07 ef51b74ca0e1d282",
        "bullet stands": "f3da64cbb04a3d2d a796bfa12122e21e",
        "mujoco stands": "1116bd121997491d 5ca2bcf8563d80a5",
        "rapier stands": "adb93c576222f21e c9d78db9b0868264",
    },
    "fronts": {"within": "b4961f87a9f83860", "stands": "89c4cb0b4f0fb8f6"},
    "keys": {
        "run on None": "9730eb5921a35ac6",
        "run on planar": "3349f79886637103",
        "run on real": "ca10210c21cc4234",
        "run on lists": "48b2759a698e92d9",
        "run on choosing": "50f056746da5447f",
        "within": "4bf9b9a6c58288fb",
        "stands": "0aa839b3a44bd526",
    },
}


@pytest.mark.parametrize("name", FOUND)
def test_the_values_are_those_that_stored_verdicts_depend_on(name):
    assert FOUND[name]() == EXPECTED[name]
