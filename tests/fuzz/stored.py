"""Small files that the product stores and reads again: valid ones, and their readers."""

import json
from dataclasses import asdict

import numpy as np

from steadyload.app.recommend.kept import FILE as FRONTS
from steadyload.app.recommend.kept import load_fronts
from steadyload.atomic import manifest_text
from steadyload.learners.generation import GenerationOptions
from steadyload.learners.generation import _claim as claim
from steadyload.methods.tuned import FILE as TUNED
from steadyload.methods.tuned import _read as read_tuned
from steadyload.stored import stored_list
from steadyload.tuning.cost import TERMS, CostModel, stored_model
from steadyload.tuning.ledger import Entry, GenerationEnd, Ledger
from steadyload.tuning.trial import TrialResult

ABOUT = {"engine": "mujoco", "space": "extended", "version": 3, "made_by": {"mujoco": "3"}}
"""What a cost model is of."""

OPTIONS = GenerationOptions(lists=2, label="fbs", seed=7)


def summed(change):
    """A change of a manifest whose checksum is, every second time, made anew."""

    def mutate(content, draw):
        changed = change(content, draw)
        if draw.random() < 0.5:
            return changed
        try:
            found = json.loads(changed)
            found.pop("checksum", None)
            return manifest_text(found).encode("utf-8", errors="replace")
        except (AttributeError, TypeError, ValueError, RecursionError):
            return changed

    return mutate


def cost():
    model = CostModel(dict.fromkeys(TERMS, 1.5), 32, 0.9, 0.1)
    return manifest_text({"about": ABOUT, "model": asdict(model)}).encode()


def noted():
    """Runs that worked in a folder."""
    runs = [{"git": "0" * 7, "versions": {"numpy": "2"}}]
    return [manifest_text({"runs": runs}).encode()]


def tuned():
    return TUNED.read_bytes()


def front():
    return FRONTS.read_bytes()


def asked():
    return manifest_text(OPTIONS.identity()).encode()


def ledger(folder):
    """The file of a search."""
    made = folder / "written"
    for old in made.glob("*"):
        old.unlink()
    written = Ledger(made, {"engine": "mujoco", "seed": 3})
    written.state("goal", 3.0)
    written.add(Entry((1, 2), 0, TrialResult(np.array([True, False]), np.array([0.5, 1.5]), 0.1)))
    written.end(GenerationEnd(0, 4, 0.25, 1.5))
    return (made / "search.jsonl").read_bytes()


def read_ledger(folder):
    Ledger.of(folder)


def read_cost(path):
    stored_model(path, ABOUT)


def read_asked(folder):
    claim(folder, OPTIONS)


def read_noted(path):
    stored_list(path, "runs", "remove it")


def read_front(path):
    load_fronts(path)


def read_tuned_file(path):
    read_tuned.__wrapped__(path)
