"""Old keys of records: each stays for one version beside the key that has taken its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

OLD_KEYS: Mapping[str, Mapping[str, str]] = {
    "verdict": {"moved_step": "moved_item"},
    "check": {"moved_step": "moved_item", "transport_moved_step": "transport_moved_item"},
    "score": {
        "displacement": "displacement_cm",
        "rotation": "rotation_deg",
        "seconds": "wall_seconds",
    },
    "uncertain": {"seconds": "wall_seconds"},
    "results": {"displacement": "displacement_cm", "rotation": "rotation_deg"},
}
"""Kind of record -> old key -> new key. To drop old keys, empty this, and take the rows "old name
of" out of docs."""


def with_old_keys(kind: str, record: Mapping[str, Any]) -> dict[str, Any]:
    """A record that also has its old keys, with the values of the new ones, at its end.

    Args:
        kind: of the record, see :data:`OLD_KEYS`.
        record: by its new keys.
    """
    old = OLD_KEYS.get(kind, {})
    return {**record, **{key: record[new] for key, new in old.items()}}
