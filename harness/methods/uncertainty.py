"""Uncertainty of a loading, and a method's verdicts on layouts that deviate from the plan."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.engines.quantities import check_ranges, quantity
from steadyload.engines.registry import world_class
from steadyload.layouts.model.deviations import NUMBERS_AN_ITEM, deviated
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.contract.method import Method, Verdict, judge
from steadyload.methods.contract.spec import bind, canonical, split_values
from steadyload.methods.simulation.scene import planar_scene

_WHERE = "uncertain"
_FRICTION = "friction"
_AXES = {"width": 0, "depth": 2}


@dataclass(frozen=True)
class Uncertainty:
    """Deviations from the plan: standard deviations of independent normal deviations.

    Centres of mass, places and weights deviate item by item, see
    :func:`steadyload.layouts.model.deviations.deviated`; friction is one number for the whole
    layout, cut off where the method's own parameter ends.

    Raises:
        ValueError: a number is out of its range, or nothing is uncertain.
    """

    com: float = quantity(
        0, "centre of mass, along each of the three axes", unit="cm", least=0, most=1000
    )
    position: float = quantity(
        0, "place, along each horizontal axis", unit="cm", least=0, most=1000
    )
    weight: float = quantity(0, "weight, as a share of it", unit="share", least=0, most=1)
    friction: float = quantity(0, "coefficient of friction of all contacts", least=0, most=10)

    def __post_init__(self) -> None:
        check_ranges(self)
        if not any(dataclasses.astuple(self)):
            names = ", ".join(f.name for f in dataclasses.fields(self))
            raise ValueError(f"nothing is uncertain; allowed: at least one of {names} above 0")

    def __str__(self) -> str:
        told = [f.name for f in dataclasses.fields(self) if getattr(self, f.name)]
        return ",".join(f"{key}={value}" for key, value in canonical(self, told))

    def without_effect(self, method: Method) -> tuple[str, ...]:
        """Names of the deviations that a method has no parameter for."""
        known = not self.friction or hasattr(method.parameters, _FRICTION)
        return () if known else (_FRICTION,)


def parse_uncertainty(text: str) -> Uncertainty:
    """Uncertainty of ``com=5mm,position=3mm,weight=5%,friction=0.1``; plain lengths are in cm.

    Raises:
        SpecError: not of this form, an unknown name, a value out of range or of another unit, or
            nothing is above 0.
    """
    found: Uncertainty = bind(Uncertainty, split_values(text, _WHERE), where=_WHERE)
    return found


def dimensions(item_count: int) -> int:
    """Number of random numbers for a layout: one for friction, then item by item."""
    return 1 + NUMBERS_AN_ITEM * item_count


def judge_deviated(
    method: Method,
    layout: Layout,
    uncertainty: Uncertainty,
    uniforms: FloatArray,
    *,
    timeout: float | None = None,
) -> list[Verdict]:
    """Verdicts on layouts that deviate from a plan; batched if the method gains from it.

    On an engine of two dimensions nothing deviates out of the plane of a planar layout. An
    exception of the method is a verdict of status ``error``.

    Args:
        method: any.
        layout: the plan.
        uncertainty: what deviates from it.
        uniforms: a row a verdict, numbers in (0, 1), shape (n, :func:`dimensions`).
        timeout: of a judgement, see :meth:`Method.judge`.
    """
    items = uniforms[:, 1:].reshape(len(uniforms), -1, NUMBERS_AN_ITEM)
    layouts = deviated(
        layout,
        items,
        centre=uncertainty.com,
        place=uncertainty.position,
        weight=uncertainty.weight,
        still=_out_of_plane(method, layout),
    )
    if not uncertainty.friction or uncertainty.without_effect(method):
        return _verdicts(method, layouts, timeout)
    rubbed = _with_friction(method, uncertainty.friction, uniforms[:, 0])
    return [
        verdict
        for one, deviating in zip(rubbed, layouts, strict=True)
        for verdict in _verdicts(one, [deviating], timeout)
    ]


def _out_of_plane(method: Method, layout: Layout) -> int | None:
    engine = method.spec.engine
    if engine is None or world_class(engine).capabilities.dimensions != 2:
        return None
    across = planar_scene(layout).across
    return None if across is None else _AXES[across]


def _with_friction(method: Method, spread: float, uniforms: FloatArray) -> list[Method]:
    from scipy.special import ndtr, ndtri

    declared = next(f for f in dataclasses.fields(method.parameters) if f.name == _FRICTION)
    ends = declared.metadata["least"], declared.metadata["most"]
    planned = method.parameters.friction
    least, most = (ndtr((end - planned) / spread) for end in ends)
    values = np.clip(planned + spread * ndtri(least + (most - least) * uniforms), *ends)
    return [
        type(method)(method.spec, dataclasses.replace(method.parameters, friction=value))
        for value in values.tolist()
    ]


def _verdicts(method: Method, layouts: Sequence[Layout], timeout: float | None) -> list[Verdict]:
    try:
        return method.judge_many(layouts, timeout=timeout)
    except Exception:  # of one of them: which one shows when each is judged by itself
        return [judge(method, layout, timeout) for layout in layouts]
