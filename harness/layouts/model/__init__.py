"""Layouts: items, pallets, floors, units, and what touches what."""

from steadyload.layouts.model.layout import TOLERANCE, Item, Layout, LayoutError, Pallet

__all__ = ["TOLERANCE", "Item", "Layout", "LayoutError", "Pallet"]
