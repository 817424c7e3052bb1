"""The page of learned methods: what its records are made of, and a rendering of small ones."""

from dataclasses import replace

import pytest

from steadyload.methods.naming import MethodKey
from steadyload.reports.pages.writing import write_page
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.learned.comparing import Curve, Found, Provenance, Trained
from steadyload.studies.learned.foreign import Agreeing, Foreign, Reason
from steadyload.studies.learned.foreign import Judged as Refusing
from steadyload.studies.learned.study import LearnedStudy
from steadyload.studies.learned.table import Judged, Table
from steadyload.studies.reliability import Abstaining, Bin, Calibrated, Risk

GROUPS = ("all", "S1", "S2a", "S2b")


def about(value, half=0.02, n=900):
    return Estimate(value, value - half, value + half, n)


def each(*values):
    return dict(zip(GROUPS, map(about, values), strict=True))


def method(title, accuracy, spec="", ahead=None):
    """A method whose every layout takes 0.35 ms, 0.3 ms of CPU time."""
    key = MethodKey(title, spec or title.lower(), title.lower())
    return MethodEvaluation(
        key, accuracy=about(accuracy), over=about(0.03), under=about(0.02), ahead=ahead,
        cpu=about(0.3, n=300), wall=about(0.35, n=300), fully_stable=about(0.8, n=40),
    )  # fmt: skip


def trained(title, accuracy, *, cases=900, difference=None):
    seeds = dict(zip(GROUPS, ((a - 0.01, a + 0.013) for a in accuracy), strict=True))
    return Trained(
        title, "plain", "lstm", 8, "labelled set", cases, 30, each(*accuracy),
        accuracy[1] - accuracy[3], seeds.pop("all"),
        seeds, None if difference is None else each(*difference),
    )  # fmt: skip


def judged(found, paper=None, best=None):
    rates = {best: 12500.0} if best else {}
    return Judged(
        found, paper, 5, paper and 26.44, 2857.1, best, rates.get(best), best and 16667.0, rates
    )


OWN = dict(zip(GROUPS, (0.85, 0.98, 0.79, 0.77), strict=True))
PAPER = dict(zip(GROUPS, (0.836, 0.987, 0.78, 0.74), strict=True))
RULE = method("SME", 0.8, ahead=about(0.05))
COSTS = CostSource(CostKind.TIMED, 300, 3.0).explained()
HELD = {g: judged(method("LSTM_e", OWN[g]), PAPER[g], 64) for g in GROUPS}
TABLE = Table(
    "lists", "test", 300, 90, HELD["all"].found.method, HELD,
    {g: [judged(RULE), HELD[g]] for g in GROUPS}, COSTS,
)  # fmt: skip
PLAIN = trained("plain", (0.80, 0.95, 0.75, 0.70))
SUPPORT = trained("support", (0.90, 0.97, 0.88, 0.85), difference=(0.10, 0.02, 0.13, 0.15))
TURNED = trained("turned", (0.81, 0.95, 0.76, 0.72), difference=(0.01, 0.0, 0.01, 0.02))
FEW = trained("ten", (0.6, 0.7, 0.6, 0.5), cases=30)
BINS = [Bin("lstm_e", "a step is unstable", 0.0, 0.1, 0.04, about(0.07, n=600))]
FOUND = Found(
    "lists", "test", 900, 15, GROUPS[1:],
    table=TABLE,
    size=[Curve("plain features", [FEW, PLAIN])],
    sources=[PLAIN, SUPPORT],
    agreement=[Agreeing("ps_opt@mujoco", about(0.93, n=1200))],
    remedies=[PLAIN, SUPPORT, TURNED],
    calibrated=[Calibrated("lstm_e", BINS[0].kind, about(0.05, 0.01), about(0.021, 0.01), BINS)],
    abstaining=[
        Abstaining(
            "lstm_e", 0.64, about(0.85), about(0.90, n=810), about(0.40, n=90), [Risk(1.0, 0.15)]
        )
    ],
    leaks=[[PLAIN, SUPPORT]],
    foreign=Foreign(
        2, 40, 20,
        [
            Refusing(
                TABLE.held, about(0.9, n=40), {"SME": about(0.55, n=40)}, RULE, 4,
                {"SME": about(0.75, n=4)},
            )
        ],
        [Reason("LSTM_e", "weight", 31, (0.5, 180.0), (4.0, 1305.0))],
        [RULE],
        [Agreeing("SME and FBS", about(0.6, n=40))],
    ),
    trainings=[
        Provenance("plain", [7], "0123456789ab", "feedbeef", 900, 30, [60], [41], 0.81, 75.0,
                   "steadyload train --option seed=7"),
    ],
    made_with={"source": "here"},
)  # fmt: skip


@pytest.mark.parametrize(("accuracy", "named"), [(0.85, True), (0.831, True), (0.82, False)])
def test_a_rule_that_is_as_accurate_as_the_networks_is_named(accuracy, named):
    rule = method("Equilibrium", accuracy, "equilibrium:time=0.3")
    groups = {**TABLE.groups, "all": [judged(rule), TABLE.groups["all"][1]]}
    assert replace(TABLE, groups=groups).rule == (rule if named else None)


def test_records_name_what_stands_out():
    assert [(one.scenario, one.title) for one in FOUND.by_scenario[:4]] == [
        ("S1", "plain"), ("S2a", "plain"), ("S2b", "plain"), ("S1", "support"),
    ]  # fmt: skip
    assert TABLE.others == [RULE]


def test_a_page_shows_its_records(tmp_path):
    study = LearnedStudy()
    page = study.page(FOUND)
    whole = write_page(page, tmp_path).read_text()
    whole += next(tmp_path.glob("report-details.*.md")).read_text()
    assert len(page.sections) == 5
    assert len(page.details) == 7
    assert len(list((tmp_path / "figures").iterdir())) == len(page.drawn) == 5
    for said in (
        "LSTM_e is right on 85.0 [83.0, 87.0] % of 900 cases",
        "S1 98.0 % and 98.7 % (lower, but the interval contains it);",
        "S2a 79.0 % and 78.0 % (higher, but the interval contains it);",
        "S2b 77.0 % and 74.0 % (higher).",
        "LSTM_e: 0.350 ms (reached; 0.300 ms of CPU time);",
        "12500 layouts/s in batches of 64 (reached; 16667 a second of CPU time)",
        "3.0 processes wanted to run, one of them ours. **The machine was busy",
        "5.0 [3.0, 7.0]",  # ahead of SME
        "79.0 to 81.3 (2)",  # seeds
        "60.0 % from 30 cases of 30 item lists, 80.0 % from 900 cases of 30 item lists.",
        "93.0 [91.0, 95.0]", "1200",  # labels that are the same
        "these gain 8 points, as is the aim: support. Significantly more accurate than plain: "
        "support. Significantly less accurate: none.",
        "15.0 [13.0, 17.0]", "25.0",  # gained, and lost in S2b
        "0.021 [0.011, 0.031]",  # calibration error
        "90.0 % without the tenth",
        "4 to 1305", "31", "refuses 90.0 [88.0, 92.0] % of 40 layouts.",
        "0123456789ab", "feedbeef", "- plain: `steadyload train --option seed=7`",
        "judge 300 cases of part `test` of the set `lists`, packed from 90 item lists.",
        "No training learnt from the item lists of any test part or was stopped by its accuracy on "
        "them, but for",
        "Trainings judge part `test` of the set `lists`: 900 cases",
    ):  # fmt: skip
        assert said in whole, said
    # What was not run is not on the page.
    few = study.page(Found(None, "validation", 900, 15, GROUPS[1:]))
    assert [section.title for section in few.details] == ["How to read this page"]
    assert not few.sections
    assert "accuracies on it are too high" in few.summary
    assert "No training" not in few.summary
