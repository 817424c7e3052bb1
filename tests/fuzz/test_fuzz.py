"""A short run of the fuzzing of all formats; and what a run finds is found."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import fuzz
from formats import COSTLY, FORMATS

INPUTS = 2_000
SEED = 14
"""One by which each of the planted readers does its harm."""


def test_no_format_ends_in_anything_but_a_named_error(tmp_path):
    summary = fuzz.fuzz(INPUTS, seed=20_240_102, kept=tmp_path)
    assert summary.findings == []
    assert sum(summary.counts.values()) == INPUTS
    tried = {name for name, *_ in summary.counts}
    assert tried == set(FORMATS)
    for name in FORMATS:
        if name not in COSTLY:  # of those there are too few here to see both
            kinds = {kind for found, kind, _ in summary.counts if found == name}
            assert kinds == {"accepted", "refused"}, name
    kinds = {kind for found, kind, _ in summary.counts if found in COSTLY}
    assert kinds == {"accepted", "refused"}


HARM = {
    "hangs": "more than 2.0 s of CPU",
    "crashes": "signal 11",
    "grows": "MemoryError",
    "raises": "KeyError: 'x'",
    "lies": "a message with control characters",
}


def test_what_harms_is_found_and_kept(tmp_path):
    summary = fuzz.fuzz(5, seed=SEED, names=tuple(HARM), kept=tmp_path)
    assert {name for name, *_ in summary.findings} == set(HARM)
    for name, number, said in summary.findings:
        assert HARM[name] in said
        assert (tmp_path / f"{name}-{SEED}-{number}").read_bytes() == b"xxx"
        assert f"| {name} | 1 | 0 |  | 1 |" in str(summary)
