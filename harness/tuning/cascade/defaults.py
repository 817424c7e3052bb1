"""Defaults of fitting a cascade; the help of its command shows them."""

from __future__ import annotations

ENGINE = "mujoco"
"""Engine of the last method."""

SIZES = (20, 40, 60, 90)
"""Largest numbers of boxes of classes of sizes, which count alike in the cost of a cascade; larger
loads are a last class. A stage may be kept for the steps of no more items than one of them."""

CANDIDATES = {
    "within": (
        "fbs",
        "equilibrium",
        "lstm_1",
        "lstm_e",
        "settling",
        "equilibrium:time=0.3",
        "ps_opt@{engine}:scope=local",
    ),
    "stands": (
        "equilibrium:margin=1",
        "settling:margin=2",
        "settling:margin=2.5",
        "settling:margin=3",
        "settling:margin=3.5",
        "settling:margin=4",
    ),
}
"""Methods that may become stages, in order, by question; for ``stands`` they pass a step where its
margin is large."""

LAST = "ps_opt@{engine}"
"""The method that decides the steps that no stage decides."""

BUDGETS = (0.5, 1.0, 2.0, 5.0)
"""Points of accuracy that stages may lose; the first is the default of a cascade."""

CONFIDENCE = 0.5
"""Of the bound that keeps within the budget: as likely too high as too low."""
