"""Ten published figures from the rows of their pages; needs pandas and pyarrow alone.

A row is a verdict on a case; it is right where it names the failing step of the label, if any.
"""

from pathlib import Path

import pandas as pd

ROWS = Path(__file__).parents[1] / "reports" / "rows"
METHODS = ("sme", "equilibrium:time=0.3", "lstm_e", "ps_opt@mujoco", "cascade@mujoco")
STANDS = ":question=stands"
ENGINES = ("bullet", "dart", "mujoco", "physx", "rapier")
PARAMETERS = ("ps3-literal", "ps_opt-paper", "ps_opt-equal", "label")


def verdicts(page, run):
    """All verdicts of a run of a page, each beside the labels of its case."""
    return pd.read_parquet(ROWS / f"{page}.parquet", filters=[("run", "==", run)])


def accuracy(found, method):
    """Percentage of the cases that have a label of its question on which a method is right."""
    own, question = found[found["method"] == method], "stands" if STANDS in method else "within"
    own = own[own[f"labelled_{question}"]]
    same = own["failing_step"].fillna(-1) == own[f"label_{question}"].fillna(-1)
    return 100 * (same & (own["status"] == "done")).mean()


def shares(found, parameters):
    """Percentages of parameters, engine and both in the differences between verdicts on a case."""
    placed = (found["failing_step"] / found["item_count"]).fillna(1.0)
    done = found.assign(placed=placed)[found["status"] == "done"]
    specs = [f"{own}@{engine}" for own in parameters for engine in ENGINES]
    case = ["layout", "scenario"]
    table = done.pivot(index=case, columns="method", values="placed")[specs].dropna()
    cases = table.to_numpy().reshape(-1, len(parameters), len(ENGINES))
    cases = cases - cases.mean(axis=(1, 2), keepdims=True)
    own, engine = ((cases.mean(axis=k) ** 2).sum() * cases.shape[k] for k in (2, 1))
    whole = (cases**2).sum()
    return ", ".join(f"{100 * part / whole:.1f}" for part in (own, engine, whole - own - engine))


lists, real = verdicts("evaluation", "spatial"), verdicts("evaluation_real", "real")
for method in (*METHODS, f"cascade@mujoco{STANDS}"):
    print(f"{method}: {accuracy(lists, method):.1f}")
for method in ("ps_opt@rapier", f"ps_opt@rapier{STANDS}"):
    print(f"{method}, 25 to 61 boxes: {accuracy(real.query('item_count < 62'), method):.1f}")
judged = verdicts("engines", "sources/lists")
for own in (PARAMETERS, PARAMETERS[2:]):
    print(f"parameters, engine, both; {len(own)} sets: {shares(judged, own)}")
