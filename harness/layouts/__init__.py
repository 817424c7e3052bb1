"""Layouts of boxes on a pallet, in centimetres and kilograms, y up."""

from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet

__all__ = ["Item", "Layout", "LayoutError", "Pallet"]
