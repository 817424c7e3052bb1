"""Quasi-random numbers: even, independent scramblings, and each item's own."""

import numpy as np
import pytest

from steadyload.methods.draws import sobol


def test_every_coordinate_has_one_point_in_every_stratum():
    for first, last in ((0, 16), (16, 32), (32, 64)):
        points = sobol(first, last, 130, seed=4, replicate=2)
        strata = np.floor(points * (last - first)).astype(int)
        assert (np.sort(strata, axis=0) == np.arange(last - first)[:, None]).all()


def test_the_first_two_coordinates_are_even_together():
    # A (0, m, 2)-net: every elementary rectangle of area 1/16 holds one of 16 points.
    points = sobol(0, 16, 2, seed=1, replicate=0)
    for across in (1, 2, 4, 8, 16):
        cells = np.floor(points * (across, 16 / across)).astype(int)
        assert len({tuple(cell) for cell in cells.tolist()}) == 16


def test_a_coordinate_hangs_on_its_own_number_alone():
    few, many = (sobol(4, 8, count, seed=9, replicate=3) for count in (7, 1201))
    assert (few == many[:, :7]).all()
    pieces = [sobol(first, first + 4, 7, seed=9, replicate=3) for first in (0, 4)]
    assert (np.concatenate(pieces) == sobol(0, 8, 7, seed=9, replicate=3)).all()


def test_scramblings_are_uniform_and_apart():
    firsts = np.array([sobol(0, 1, 40, seed=0, replicate=r)[0] for r in range(500)])
    assert (firsts.mean(axis=0)) == pytest.approx(np.full(40, 0.5), abs=0.06)
    assert firsts.var(axis=0) == pytest.approx(np.full(40, 1 / 12), abs=0.02)
    together = np.corrcoef(firsts.T)[~np.eye(40, dtype=bool)]
    assert np.abs(together).max() < 0.2
    other = sobol(0, 1, 40, seed=1, replicate=0)[0]
    assert not np.isclose(firsts, other).all(axis=1).any()


def test_a_sum_is_much_nearer_to_its_mean_than_by_random_numbers():
    means = [sobol(0, 64, 20, seed=0, replicate=r).sum(axis=1).mean() for r in range(60)]
    random = 20 / 12 / 64
    assert np.mean((np.array(means) - 10.0) ** 2) < random / 100


def test_beyond_the_known_coordinates_numbers_are_random():
    points = sobol(0, 4, 22_000, seed=1, replicate=0)
    assert points.shape == (4, 22_000)
    assert (points > 0.0).all()
    assert (points < 1.0).all()
    assert points[:, 21_201:].mean() == pytest.approx(0.5, abs=0.03)
    again = sobol(2, 4, 22_000, seed=1, replicate=0)
    assert (again == points[2:]).all()
