# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Costs of slabs, learnt from printed ones, and the cuts that follow from them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEAST_SECONDS = 0.5
"""A share that is shorter spends its time on being handed around."""
MOST_SECONDS = 10.0
"""What a worker that dies loses, and Ctrl-C waits for."""
LIFE_PART = 10
"""Where workers die, a share is such a part of their life, so that most are printed before the next death."""
SHARES_LEFT = 6
"""Each share is such a part of what is left for each worker, so that the last ones are short."""
MOST_BYTES = 32_000_000
"""Of a share's slices."""
SAMPLES = 9


@dataclass(frozen=True)
class ShareCost:
    """The cost of a share.

    Attributes
    ----------
    first, end : int
        The range of its slabs, [first, end), of 8 slices each.
    seconds, processor_seconds : float
        Wall time and processor time, in seconds.
    bytes : int
        The size of its slices as written.
    worker : str
        The address of the worker that printed it.
    """

    first: int
    end: int
    seconds: float
    processor_seconds: float
    bytes: int
    worker: str = ""


def sample_places(first: int, end: int, workers: int) -> list[int]:
    """Returns the slabs to print before the others: the first, and some spread over the height.

    There is one for each worker, so that all are busy at once, but at most a quarter of the slabs.
    """
    slabs = end - first
    count = min(max(SAMPLES, workers), -(-slabs // 4))
    return sorted({first, *(first + (2 * k + 1) * slabs // (2 * count) for k in range(count))})


class CostModel:
    """Seconds and bytes of each slab of [first, end), interpolated between known slabs."""

    def __init__(self, first: int, end: int) -> None:
        self._slabs = np.arange(first, end) + 0.5
        self._first = first
        self._known: list[tuple[float, float, float]] = []  # middle, seconds and bytes of a slab
        self._table: NDArray[np.float64] | None = None

    def add(self, cost: ShareCost) -> None:
        """Adds the cost of a share."""
        slabs = cost.end - cost.first
        self._known.append(((cost.first + cost.end) / 2, cost.seconds / slabs, cost.bytes / slabs))
        self._table = None

    @property
    def is_known(self) -> bool:
        """Whether the cost of any slab is known."""
        return bool(self._known)

    def sums(self, first: int, end: int) -> NDArray[np.float64]:
        """Returns the cumulative seconds and bytes of slabs from the first, [2][slab]."""
        if self._table is None:
            middle, *values = zip(*sorted(self._known))
            self._table = np.array([np.interp(self._slabs, middle, value) for value in values])
        return np.cumsum(self._table[:, first - self._first : end - self._first], axis=1)


def settled(samples: Sequence[int], unfinished: Collection[int], end: int) -> int:
    """Returns the slab up to which costs are known: the last sample before an unfinished one."""
    if not unfinished:
        return end
    lowest = min(unfinished)
    return max((slab + 1 for slab in samples if slab < lowest), default=lowest)


def most_seconds(life_seconds: float | None) -> float:
    """Returns the limit of a share's seconds, given the lifetime of workers; None means that none has died."""
    return MOST_SECONDS if life_seconds is None else min(MOST_SECONDS, life_seconds / LIFE_PART)


def share_end(
    model: CostModel, first: int, limit: int, known: int, end: int, workers: int, most: float | None = None
) -> int:
    """Returns the end of a share that begins with slab `first` and extends to `limit` at most.

    From slab `known` on, a share is one slab, since costs there may be unknown. `most` limits its seconds.
    """
    if first >= known or not model.is_known:
        return first + 1
    seconds, size = model.sums(first, end)
    target = max(seconds[-1] / (SHARES_LEFT * max(workers, 1)), LEAST_SECONDS)
    target = min(target, MOST_SECONDS if most is None else most)
    slabs = min(int(np.searchsorted(seconds, target)), int(np.searchsorted(size, MOST_BYTES, "right")))
    return min(first + max(slabs, 1), limit, known)
