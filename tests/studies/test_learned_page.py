"""The page of learned judges: closed forms of its numbers, and that it says what records hold."""

from dataclasses import replace

import numpy as np
import pytest

from steadyload.methods.naming import MethodKey
from steadyload.reports.pages.writing import write_page
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.runs.paper import paper
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import (
    BINS,
    Abstention,
    Reliability,
    ReliabilityBin,
    abstention,
    reliability,
)
from steadyload.studies.learned.calibration import MethodCalibration, sureness
from steadyload.studies.learned.foreign import Foreign, ForeignRow
from steadyload.studies.learned.page import learned_page
from steadyload.studies.learned.summary import (
    LeakRow,
    Learned,
    MethodTable,
    ProvenanceRow,
    SizeCurve,
    TrainedRow,
)

SCENARIOS = ("S1", "S2a", "S2b")
PARTS = ("all", *SCENARIOS)


def about(value, half=0.02, n=900):
    return Estimate(value, value - half, value + half, n)


def each(*values):
    return dict(zip(PARTS, map(about, values), strict=True))


def judge(title, accuracy, ahead=(None, None, None, None), *, wall):
    """A row a part, with times [ms]."""
    key = MethodKey(title, title.lower(), title.lower())
    over, under = (0.03, 0.01, 0.03, 0.04), (0.02, 0.01, 0.03, 0.04)
    return [
        MethodEvaluation(
            key, part, accuracy=about(right), over=about(late), under=about(early),
            ahead=None if lead is None else about(lead), cpu=about(0.9 * wall, n=300),
            wall=about(wall, n=300),
        )
        for part, right, late, early, lead in zip(PARTS, accuracy, over, under, ahead, strict=True)
    ]  # fmt: skip


def timed(load):
    return CostSource(CostKind.TIMED, 300, load)


def trained(title, accuracy, *, cases=900, lists=30, difference=None):
    return TrainedRow(
        title, "plain", "lstm", 8, "labelled set", lists, cases, each(*accuracy),
        {p: (a - 0.01, a + 0.013) for p, a in zip(PARTS, accuracy, strict=True)},
        None if difference is None else each(*difference),
    )  # fmt: skip


def table(wall, batches, load):
    """The table of a rule and a network with some wall time [ms], in batches, too."""
    rule = judge("SME", (0.80, 0.86, 0.80, 0.74), (0.05, 0.12, 0.0, 0.03), wall=0.2)
    network = judge("LSTM_e", (0.85, 0.98, 0.79, 0.77), wall=wall)
    return MethodTable(
        network[0].method,
        {part: rows for part, *rows in zip(PARTS, rule, network, strict=True)},
        {"lstm_e": next(row for row in paper().rows if row.title == "LSTM_e")},
        {"lstm_e": batches},
        5,
        timed(load),
    )


TABLE = table(0.35, {8: (0.2, 0.25), 64: (0.06, 0.08)}, 1.0)
PLAIN = trained("plain", (0.80, 0.95, 0.75, 0.70))
SUPPORT = trained("support", (0.90, 0.97, 0.88, 0.85), difference=(0.10, 0.02, 0.13, 0.15))
NO_GAIN = trained("turned", (0.81, 0.95, 0.76, 0.72), difference=(0.01, 0.0, 0.01, 0.02))
RELIABLE = Reliability(
    about(0.05, 0.01), about(0.021, 0.01),
    (ReliabilityBin(0.0, 0.1, 0.04, about(0.07, n=600)),
     ReliabilityBin(0.9, 1.0, 0.97, about(0.93, n=300))),
)  # fmt: skip
CALIBRATED = MethodCalibration(
    "lstm_e", RELIABLE, RELIABLE,
    Abstention(
        0.64, about(0.85), about(0.90, n=810), about(0.40, n=90), ((0.5, 0.02), (1.0, 0.15))
    ),
)  # fmt: skip
FOREIGN = Foreign(
    2, 40, 20,
    (ForeignRow(TABLE.held, about(0.9, n=40), (("weight", 31, (0.5, 180.0), (4.0, 1305.0)),),
                {"SME": about(0.55, n=40)}, {"SME": about(0.75, n=4)}, about(0.5, n=40)),),
    {"SME": about(0.8, n=40)},
    {("SME", "FBS"): about(0.6, n=40)},
)  # fmt: skip
FROM = ProvenanceRow(
    "plain", (7,), "steadyload train --option seed=7", "0123456789ab", 900, 30, (60,), (41,), 0.81,
    75.0, "feedbeef",
)  # fmt: skip
WHOLE = Learned(
    "test", 900, 15, SCENARIOS,
    table=TABLE,
    size=(SizeCurve("plain features", (
        trained("ten", (0.6, 0.7, 0.6, 0.5), cases=30, lists=3), PLAIN,
    )),),
    sources=(PLAIN, SUPPORT),
    agreement={"ps_opt@mujoco": about(0.93, n=1200)},
    remedies=(PLAIN, SUPPORT, NO_GAIN),
    calibration=(CALIBRATED,),
    leak=(LeakRow(PLAIN, SUPPORT),),
    foreign=FOREIGN,
    trainings=(FROM,),
)  # fmt: skip


def test_a_rule_that_is_as_accurate_as_the_networks_is_named_beside_them():
    held, other = TABLE.rows[PARTS[0]][1], TABLE.rows[PARTS[0]][0]
    rule = replace(other, method=replace(other.method, spec="equilibrium:time=0.3"))
    for value, named in ((held.accuracy.value, True), (held.accuracy.low - 0.01, False)):
        row = replace(rule, accuracy=about(value, 0.01))
        table = replace(TABLE, rows={**TABLE.rows, PARTS[0]: [row, held]})
        summary = learned_page(replace(WHOLE, table=table), {}).summary
        assert ("little of this figure is due to the network" in summary) == named


def section(learned, title):
    return next(s for s in learned_page(learned, {}).sections if s.title == title)


def said(learned, title):
    found = section(learned, title)
    return "\n".join((found.text, *map(str, found.tables)))


def test_a_page_says_what_its_record_holds(tmp_path):
    path = write_page(learned_page(WHOLE, {"source": "here"}), tmp_path)
    text = path.read_text()
    [details] = tmp_path.glob("report-details.*.md")
    whole = text + details.read_text()
    assert text.startswith(
        "# Learned judges\n\nLSTM_e is right on 85.0 [83.0, 87.0] % of 900 cases"
    )
    for number in (
        "85.0 [83.0, 87.0]",  # accuracy of LSTM_e
        "78.0",  # the paper's on S2a
        "12.0 [10.0, 14.0]",  # ahead of SME on S1
        "0.350", "26.44", "12500", "16667",  # ms, layouts a second of wall and CPU time
        "79.0 to 81.3 (2)",  # seeds
        "93.0 [91.0, 95.0]", "1200",  # labels that are the same
        "15.0 [13.0, 17.0] points on S2b",
        "0.021 [0.011, 0.031]",  # calibration error
        "90.0 % without the tenth",
        "4 to 1305", "31",
        "0123456789ab", "feedbeef", "steadyload train --option seed=7",
    ):  # fmt: skip
        assert number in whole, number
    pictures = {p.name: p.read_bytes() for p in (tmp_path / "figures").iterdir()}
    assert len(pictures) == 5
    again = tmp_path / "again"
    assert write_page(learned_page(WHOLE, {"source": "here"}), again).read_text() == text
    assert {p.name: p.read_bytes() for p in (again / "figures").iterdir()} == pictures


def test_every_table_says_its_n():
    for found in learned_page(WHOLE, {}).sections:
        for table in found.tables:
            header = next(line for line in str(table).splitlines() if line.startswith("|"))
            columns = [cell.strip() for cell in header.strip("|").split("|")]
            assert {"n", "cases", "layouts"} & set(columns), (found.title, columns)


@pytest.mark.parametrize(
    ("part", "title"),
    [
        ("table", "Beside other methods"),
        ("size", "Size of the training set"),
        ("sources", "Label source"),
        ("remedies", "Shifted centres of mass"),
        ("calibration", "Calibration, and not judging the unsure"),
        ("leak", "What a leak is worth"),
        ("foreign", "Layouts of another kind"),
        ("trainings", "Where the weights come from"),
    ],
)
def test_what_was_not_run_is_not_on_the_page(part, title):
    nothing = None if part in ("table", "foreign") else ()
    assert title in [s.title for s in learned_page(WHOLE, {}).sections]
    assert title not in [
        s.title for s in learned_page(replace(WHOLE, **{part: nothing}), {}).sections
    ]


def test_bars_are_met_or_missed():
    told = said(WHOLE, "Beside other methods")
    assert "S1 98.0 % against 98.7 % (missed, the interval holds the bar)" in told
    assert "S2a 79.0 % against 78.0 % (reached, the interval holds the bar)" in told
    assert "S2b 77.0 % against 74.0 % (reached)" in told
    assert "0.350 ms a layout one at a time, at most 0.4 ms (0.315 ms of CPU time)" in told
    assert "12500 layouts/s with 64 at once, at least 10000 (16667 a second" in told
    slow = table(0.5, {8: (0.1, 0.2)}, 3.0)
    told = said(replace(WHOLE, table=slow), "Beside other methods")
    assert "0.500 ms a layout one at a time, above 0.4 ms (0.450 ms" in told
    assert "5000 layouts/s with 8 at once" in told
    assert "below 10000" in told
    assert "3.0 processes wanted to run, one of them ours. **The machine was busy" in told
    told = said(WHOLE, "Shifted centres of mass")
    assert "plain 25.0; support 12.0; turned 23.0" in told
    assert "At least 8 points above plain on S2b: support." in told
    assert "- turned: 2.0 [0.0, 4.0] points on S2b, not significantly different." in told


def test_validation_is_said_to_have_been_looked_at():
    assert (
        "Nothing of these item lists was learnt from but the leaky way"
        in learned_page(WHOLE, {}).summary
    )
    summary = learned_page(replace(WHOLE, part="validation"), {}).summary
    assert "accuracies are too high" in summary
    assert "Nothing of these" not in summary


def test_brier_and_calibration_error_have_closed_forms():
    # Ten say 0.75 and six come true; ten say 0.2 and two do.
    p = np.repeat([0.75, 0.2], 10)
    y = np.repeat([1, 0, 1, 0], [6, 4, 2, 8])
    found = reliability(p, y, np.arange(20))
    assert found.brier.value == pytest.approx(
        (6 * 0.25**2 + 4 * 0.75**2 + 2 * 0.8**2 + 8 * 0.2**2) / 20
    )
    assert found.error.value == pytest.approx(0.5 * 0.15 + 0.5 * 0.0)
    assert [(b.happened.value, b.happened.n) for b in found.bins] == [(0.2, 10), (0.6, 10)]
    assert [b.mean for b in found.bins] == pytest.approx([0.2, 0.75])
    halves = reliability(p, y, np.arange(20), (0.0, 0.5, 1.0))
    assert [(b.low, b.high) for b in halves.bins] == [(0.0, 0.5), (0.5, 1.0)]
    assert halves.error.value == pytest.approx(found.error.value)
    sure = reliability([0.0, 1.0, 1.0], [0, 1, 1], [0, 1, 2])
    assert (sure.brier.value, sure.error.value, sure.error.high) == (0.0, 0.0, 0.0)
    wrong = reliability([0.0, 1.0, 1.0], [1, 0, 0], [0, 1, 2])
    assert (wrong.brier.value, wrong.error.value, wrong.error.low) == (1.0, 1.0, 1.0)


def test_what_keeps_its_word_has_next_to_no_error():
    random = np.random.default_rng(1)
    p = random.uniform(size=20_000)
    y = random.uniform(size=20_000) < p
    lists = random.integers(0, 400, 20_000)
    kept, broken = reliability(p, y, lists), reliability(np.sqrt(p), y, lists)
    assert kept.error.value < 0.012
    # The mean of sqrt(p) - p over uniform p is 2/3 - 1/2.
    assert broken.error.low < 1 / 6 < broken.error.high
    assert kept.brier.value == pytest.approx(1 / 6, abs=0.005)  # mean of p (1 - p)
    assert len(kept.bins) == BINS
    # Lists of one opinion each leave an interval as wide as their number makes it.
    few = reliability(np.repeat(p[:40], 50), np.repeat(y[:40], 50), np.repeat(np.arange(40), 50))
    single = reliability(p[:40], y[:40], np.arange(40))
    assert few.error.high - few.error.low == pytest.approx(single.error.high - single.error.low)


def test_how_sure_a_score_is_follows_from_its_steps():
    p = np.array([[0.2, 0.9, 0.7], [0.2, 0.1, 0.99], [0.6, 0.3, 0.2], [0.1, 0.2, 0.3]])
    sure = sureness(p, np.array([3, 2, 3, 3]))
    assert sure == pytest.approx([0.8 * 0.9, 0.8 * 0.9, 0.6, 0.9 * 0.8 * 0.7])
    # The probabilities of all scores of a layout are a distribution.
    every = [np.prod(1.0 - p[0, :k]) * (p[0, k] if k < 3 else 1.0) for k in range(4)]
    assert sum(every) == pytest.approx(1.0)
    assert every[1] == pytest.approx(sure[0])


def test_what_abstaining_gives():
    sure = np.linspace(1.0, 0.05, 20)
    right = np.ones(20, bool)
    right[[18, 19]] = False
    found = abstention(sure, right, np.arange(20))
    assert (found.every.value, found.sure.value, found.unsure.value) == (0.9, 1.0, 0.0)
    assert (found.sure.n, found.unsure.n) == (18, 2)
    assert found.least == pytest.approx(sure[17])
    assert found.curve[-1] == pytest.approx((1.0, 0.1))
    assert found.curve[-2] == pytest.approx((0.95, 1 / 19))
    assert all(wrong == 0.0 for _, wrong in found.curve[:-2])
    # Who is right when unsure gains nothing.
    assert abstention(sure[::-1], right, np.arange(20)).sure.value < 0.9
