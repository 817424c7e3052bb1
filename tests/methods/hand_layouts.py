"""Layouts written down as numbers, and the step at which a method says that they fail."""

from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import make_method


def layout(*boxes):
    """Boxes as (x, y, z, width, height, depth[, weight[, offset x]])."""
    items = []
    for step, box in enumerate(boxes):
        weight = box[6] if len(box) > 6 else 1.0
        offset = box[7] if len(box) > 7 else 0.0
        items.append(Item(step, box[:3], box[3:6], weight, (offset, 0.0, 0.0)))
    return Layout("hand", Pallet(200.0, 200.0, 200.0), tuple(items))


def failing_step(spec, lay):
    verdict = make_method(spec).judge(lay)
    assert verdict.status == "done", verdict.reason
    return verdict.failing_step
