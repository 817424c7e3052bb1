"""Layout files read as a batch: files of many forms, and both readers, which have to agree."""

import json

import numpy as np

from steadyload.layouts.batch_files import plain_batch
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.json_batch import batch_of_json
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import LayoutError

CHUNKS = (120, 300, 1000, 64 * 1024)
"""Bytes of a file that are read at a time. The first of them hold what stands before layouts."""


class DifferenceError(Exception):
    """The two readers do not say the same."""


def read_alike(path):
    """Read a file as layouts and as a batch; an error that the first raises is handed out."""
    return _compared(path, plain_batch(path, {}))


def read_json_alike(path):
    """The same, and in chunks of a size that depends on that of the file."""
    content = path.read_bytes()
    size = CHUNKS[len(content) % len(CHUNKS)]
    chunks = (content[k : k + size] for k in range(0, len(content), size))
    return _compared(path, plain_batch(path, {}), batch_of_json(chunks, {}))


def _compared(path, *found):
    """The error of a file; what else is found of it has to be what the reader of layouts finds."""
    expected, error = None, None
    try:
        expected = _in_memory(LayoutBatch.of(read_layouts(path)))
    except LayoutError as raised:
        error = raised
    for batch in found:
        if batch is not None and _in_memory(batch) != expected:
            raise DifferenceError(str(error))
    return error


def _in_memory(batch):
    return {
        key: (values.dtype, values.shape, values.tobytes())
        if isinstance(values, np.ndarray)
        else (values, repr(values))
        for key, values in {**vars(batch), "kinds": batch.pallets}.items()
    }


def rewritten(change):
    """A change of a JSON file that is first written in another form, which every third stays."""

    def mutate(content, draw):
        whole = json.loads(content)
        for layout in whole["layouts"]:
            layout["name"] += draw.choice(("", "", ":", "\u00e4", "}]}, {", '"'))
            _reword(layout, draw)
        if draw.random() < 0.3:
            _drop(whole, draw.choice(("name", "mass_offset")))
        made = json.dumps(
            whole,
            indent=draw.choice((None, None, 0, 1, "\t")),
            separators=draw.choice(((",", ":"), (", ", ": "))),
            ensure_ascii=draw.random() < 0.5,
        ).encode()
        return made if draw.random() < 0.3 else change(made, draw)

    return mutate


def _reword(layout, draw):
    """Change the forms of values, and some values: most stay valid."""
    if draw.random() < 0.3:
        draw.shuffle(layout["items"])
    if draw.random() < 0.3:
        layout["pallet"]["overhang"] = draw.choice((0, -0.0, 10, 12.5, 3))
    for item in layout["items"]:
        item["mass_offset"][1] = draw.choice((0, -0.0, 1, 1e-300, 0.1 + 0.2, -1))
        item["weight"] *= draw.choice((1, 1.1, 10**3))
        item["size"] = [draw.choice((side, int(side), side / 3.0)) for side in item["size"]]
    if draw.random() < 0.1:
        item = draw.choice(layout["items"])
        values = draw.choice((item["mass_offset"], item["position"], item["size"]))
        values[draw.randrange(3)] = draw.choice((2**63, 2**64, True, 1e300, -1, None, "1", 10**400))


def _drop(whole, key):
    for layout in whole["layouts"]:
        for item in layout["items"]:
            item.pop(key, None)
