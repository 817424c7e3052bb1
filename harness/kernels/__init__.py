"""Compiled functions over arrays: contacts, static rules, equilibrium and its motion model.

A layout is handed over as read-only, C-contiguous arrays: ``lower`` and ``upper`` (J, 3) [cm],
``weights`` (J,) [kg], ``offsets`` (J, 3) [cm], as :class:`~steadyload.layouts.model.Layout` has,
and ``floor`` (5,): the corners x0, z0, x1, z1 of what carries [cm], infinite for a plane, and its
height above the ground [cm], 0 for a plane. A batch has the items of all layouts one after the
other, ``starts`` (L + 1,) with the first item of each, and ``floors`` (L, 5).
"""
