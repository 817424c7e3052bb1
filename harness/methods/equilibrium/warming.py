"""The compiled balance of single steps, loaded before a judgement is timed."""

from __future__ import annotations

from functools import cache

from steadyload.methods.contract.warming import one_item
from steadyload.statics.balance import VerticalBalance


@cache
def load_balance() -> None:
    """Compile the balance of single steps, or load the compiled code; once a process."""
    VerticalBalance(one_item()).place(0)
