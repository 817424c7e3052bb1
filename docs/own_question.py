"""A question of your own: on which items is PS_opt how accurate, by engine, with 95 % intervals?

Run it from the root of a clone. Columns are in reports/rows/README.md, shares in runs/frames.py.
"""

import steadyload as sl
from steadyload.runs import frames

rows = sl.rows("evaluation")
rows = rows[(rows["run"] == "spatial") & (rows["method_name"] == "ps_opt")]
rows = rows[(rows["question"] == "within") & ~rows["method"].str.contains("paper")]
rows = rows[rows["labelled_within"] & (rows["repetition"] == 0)]  # a null label: stable
placed = rows["failing_step"].fillna(rows["item_count"])
rows = rows.assign(
    right=(rows["status"] == "done") & (placed == rows["label_within"].fillna(rows["item_count"])),
    cluster=list(zip(rows["class"], rows["list"], strict=True)),
)
shares = frames.share(rows, "right", ["class", "engine"])
print(shares.map(lambda own: f"{own.value:.1%} [{own.low:.1%}, {own.high:.1%}]").unstack("class"))
