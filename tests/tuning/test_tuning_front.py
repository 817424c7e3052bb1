"""What a multi-objective search is told of genotypes that were given up."""

import numpy as np
import pytest

from steadyload.tuning.cases import CaseSource
from steadyload.tuning.ledger import Entry
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.search import Search
from steadyload.tuning.trial import FrontRace, TrialResult

CASES = 36


def trial(right, count, cost):
    """The first ``right`` of ``count`` cases are right; each costs the same."""
    return TrialResult(np.arange(count) < right, np.full(count, cost))


DEAR, CHEAP = trial(36, CASES, 10.0), trial(20, CASES, 2.0)
LOST = trial(15, 30, 2.1)
"""Behind the cheap one by 5, and a little dearer."""


def test_the_one_ahead_costs_no_more():
    race = FrontRace((CHEAP, DEAR))
    assert race.lost(LOST)
    assert race.ahead(LOST) is CHEAP
    assert race.ahead(trial(0, 30, 11.0)) is DEAR
    assert FrontRace((DEAR,)).ahead(LOST) is None


def test_what_was_given_up_is_told_as_beaten_in_both(tmp_path):
    """Held against the dear one it would be right on 36 - 15 cases, more than the cheap one."""
    pytest.importorskip("optuna")
    options = SearchOptions(
        "mujoco", algorithm="nsga2", population=4, generations=2, source=CaseSource(limit=12)
    )
    search = Search(tmp_path, options)
    start = search.space.start
    other, lost = ((*start[:-1], at) for at in range(2))
    search.ledger.facts["goal"] = 6.0
    for genotype, generation, judged in ((start, -1, CHEAP), (other, 0, DEAR), (lost, 1, LOST)):
        search.ledger.entries[genotype] = Entry(genotype, generation, judged)
    assert len(search.ledger.entries) == 3
    [(_, accuracy, cost)] = search._worth([lost], 1)
    assert accuracy < CHEAP.accuracy
    assert cost > CHEAP.mean_cost
