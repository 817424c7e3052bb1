"""Batches that are judged in several threads of this process."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from steadyload.layouts.model.batch import LayoutBatch
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.verdict import BatchVerdicts, Finding
from steadyload.numbers import number_within


def evaluate_in_threads(method: Method, batch: LayoutBatch, threads: int) -> BatchVerdicts:
    """As :meth:`Method.evaluate`, in several threads: its compiled code holds no lock.

    Args:
        method: that judges batches.
        batch: the layouts; each thread has about as many boxes as another.
        threads: 1 or more.

    Raises:
        NumberError: the number of threads is not finite, 1 or more.
        NotBatchedError: the method judges one layout at a time.
    """
    count = min(int(number_within("threads", threads, 1.0)), max(len(batch), 1))
    if count == 1:
        return method.evaluate(batch)
    shares = np.linspace(0, batch.starts[-1], count + 1)[1:-1]
    ends = sorted({0, *np.searchsorted(batch.starts, shares).tolist(), len(batch)})
    parts = [batch[start:end] for start, end in pairwise(ends)]
    with ThreadPoolExecutor(len(parts)) as pool:
        found = list(pool.map(method.evaluate, parts))
    findings = [one.finding for one in found]

    def finding(k: int) -> Finding:
        part = int(np.searchsorted(ends, k, "right")) - 1
        own = findings[part]
        assert own is not None
        return own(k - ends[part])

    return BatchVerdicts(
        np.concatenate([one.status for one in found]),
        np.concatenate([one.failing_step for one in found]),
        np.concatenate([one.displacement for one in found]),
        np.concatenate([one.rotation for one in found]),
        None if None in findings else finding,
    )
