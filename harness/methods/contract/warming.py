"""A first judgement, whose cost counts in no other."""

from __future__ import annotations

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.contract.method import Method


def judge_one_item(method: Method) -> Layout:
    """Compile what a method judges with, or load the compiled code; the layout of that item."""
    item = Item(0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 1.0)
    layout = Layout("first", Pallet(1.0, 1.0, 1.0), (item,))
    method.judge(layout)
    return layout
