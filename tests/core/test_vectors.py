"""The C library finds the numbers of the test vectors: to the bit, or within two units."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import vectors


@pytest.fixture(scope="module")
def rows():
    return vectors.read()


def test_the_file_has_thousands_of_layouts_and_every_part(rows):
    assert 3000 <= len(rows) <= 5000
    assert vectors.FILE.stat().st_size < 2_000_000
    for part in vectors.PARTS:
        count = sum(part in row.expected for row in rows)
        assert count == len(rows) if part in vectors.OF_ALL else count > 150


@pytest.mark.parametrize("part", vectors.PARTS)
def test_numbers_are_those_of_the_vectors(part, rows):
    found = vectors.differences(part, rows)
    assert not found, "\n".join([f"{len(found)} differ", *found[:20]])


def test_numbers_differ_by_a_bit_or_by_units_in_the_last_place():
    expected = np.array([1.0, 0.0, np.nan, np.inf, 3.0, 1.0])
    found = np.array([np.nextafter(1.0, 2.0), -0.0, np.nan, np.inf, 3.0, 1.0 + 3 * 2.0**-52])
    assert vectors.differing(found, expected, 0).tolist() == [True, True, False, False, False, True]
    assert vectors.differing(found, expected, 2).tolist() == [False] * 5 + [True]
    whole = np.array([1, 2], np.int32)
    assert vectors.differing(whole, whole[::-1].copy(), 2).all()
