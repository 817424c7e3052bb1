"""Questions by their words: every door takes a word as it takes the question, or refuses it."""

import json

import pytest

import steadyload as sl
from steadyload.app.check_defaults import default_method
from steadyload.app.recommend.front import front_for
from steadyload.app.recommend.kept import load_fronts
from steadyload.cli import main
from steadyload.labelling.further_verdicts import add_further_verdicts
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.model.question import Question, QuestionError
from steadyload.methods.cascade.thresholds import load_thresholds
from steadyload.methods.tuned import tuned
from steadyload.runs.able import asked_question, asked_to_stand, spec_with_question


@pytest.fixture(scope="module")
def lists():
    return load_benchmark(LISTS)


DOORS = {
    "select": lambda lists, question: lists.select(Part.TEST, question=question),
    "labels_on": lambda lists, question: lists.labels_on(question),
    "further_verdicts_on": lambda lists, question: lists.further_verdicts_on(question),
    "confidence_on": lambda lists, question: lists.confidence_on(question),
    "front_for": lambda lists, question: front_for(load_fronts(), question, 30).measured_on(),
    "load_thresholds": lambda lists, question: load_thresholds("rapier", question=question).made_of,
    "tuned": lambda lists, question: tuned(question),
    "default_method": lambda lists, question: default_method(30, question),
}


@pytest.mark.parametrize("door", DOORS)
def test_a_word_is_taken_as_the_question_that_it_names(lists, door):
    answers = {question: str(DOORS[door](lists, question)) for question in Question}
    assert len({*answers.values()}) == len(Question)
    assert {str(q): str(DOORS[door](lists, str(q))) for q in Question} == answers


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("word", ["stand", "STANDS", "", None, 1])
def test_another_word_is_refused(lists, door, word):
    with pytest.raises(QuestionError, match=r"question is .*; allowed: within, stands"):
        DOORS[door](lists, word)


def test_further_verdicts_are_refused_before_anything_is_written(tmp_path):
    with pytest.raises(QuestionError):
        add_further_verdicts(tmp_path, question="stand")
    assert not [*tmp_path.iterdir()]


def test_labels_of_stands_are_selected_by_the_word(lists):
    """They were those of the other question: the word was compared by identity."""
    labels = lists.labels_on(Question.STANDS).set_index(["layout", "scenario"])["failing_step"]
    cases = lists.select(Part.TEST, question="stands").set_index(["layout", "scenario"])
    assert cases["failing_step"].fillna(-1).tolist() == labels.loc[cases.index].fillna(-1).tolist()


@pytest.mark.parametrize(
    ("named", "spec", "shown"),
    [
        ("ps_opt@mujoco", "ps_opt@mujoco:question=stands", "ps_opt@mujoco:question=stands"),
        ("ps_opt@mujoco:question=within",) * 3,
        ("sme", "sme", "sme"),
        ("lstm_1:weights=there", "lstm_1:weights=there", "lstm_1:weights=there,question=within"),
        ("ps3@mujoco", "ps3@mujoco", "ps3@mujoco:question=within"),
    ],
)
def test_methods_are_asked_whether_a_load_stands_unless_another_question_is_stated(
    named, spec, shown
):
    method = asked_to_stand(named)
    assert str(method.spec) == spec
    assert spec_with_question(spec) == shown
    assert asked_to_stand(method) is method


def test_score_and_check_answer_the_same_question_and_name_it(tmp_path, capsys, in_this_process):
    """A box that tips too slowly to have moved too far within 0.3 s."""
    block = Item(0, (40.0, 0.0, 20.0), (20.0, 20.0, 20.0), 10.0)
    upper = Item(1, (50.2, 20.0, 20.0), (20.0, 20.0, 20.0), 10.0)
    file = tmp_path / "a.json"
    layout = Layout("slow", Pallet(120.0, 150.0, 80.0), (block, upper))
    write_layouts(file, [layout], Format.NATIVE)
    found = {}
    for command in ("check", "score"):
        for words in (("ps_opt@mujoco",), ("ps_opt@mujoco:question=within",)):
            main([command, str(file), "-m", *words, "--json"])
            [record] = json.loads(capsys.readouterr().out)
            found[command, words[0]] = record["failing_step"], record["question"]
            main([command, str(file), "-m", *words])
            out = capsys.readouterr().out
            assert f"ps_opt@mujoco:question={record['question']}" in out
    stands, within = (1, "stands"), (None, "within")
    assert list(found.values()) == [stands, within, stands, within]
    assert sl.check(layout, "ps_opt@mujoco").to_dict()["question"] == "stands"
    assert asked_question(sl.check(layout, "ps_opt@mujoco").method) == Question.STANDS
