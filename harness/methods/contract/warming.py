"""A first judgement, whose cost counts in no other."""

from __future__ import annotations

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.contract.method import Method


def one_item() -> Layout:
    """A layout of one item that is wide enough to stand whatever margin a method has."""
    item = Item(0, (0.0, 0.0, 0.0), (100.0, 100.0, 100.0), 1.0)
    return Layout("first", Pallet(100.0, 100.0, 100.0), (item,))


def judge_one_item(method: Method) -> None:
    """Compile what a method judges with, or load the compiled code."""
    method.judge(one_item())
