# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The workers of a cluster: how many there are, how long they live, and whether they can print."""

from __future__ import annotations

import threading
import time
import warnings
from collections import deque
from collections.abc import Callable
from typing import Any

from ..errors import PrintWarning
from . import worker
from .worker import ClusterError

LOOK_SECONDS = 1.0
QUIET_SECONDS = 30.0
"""How long a print waits for workers before it says so; then it doubles."""
_CHECK_SECONDS = 10.0
# Of the deaths of workers, the last few tell how long the others are going to live.
_DEATHS_KNOWN = 4

clock = time.monotonic


class Workers:
    """The workers of a cluster, which may come and go; new ones are asked for their version.

    A worker without the package cannot read a task and is dropped by Dask, so it is found here or not at all. `where`
    describes the progress of the print. ClusterError is raised after `limit` seconds without a worker; None means never.
    """

    def __init__(self, client: Any, limit: float | None, where: Callable[[], str]) -> None:
        self._client = client
        self._limit = limit
        self._where = where
        self._seen = self._began = clock()
        self._there: set[str] = set()
        self._working = 0
        self._worked_seconds = 0.0  # of all workers together
        self._marks = deque([0.0], _DEATHS_KNOWN + 1)  # when workers died, in those; the beginning first
        self._dry_since: float | None = None
        self._told = QUIET_SECONDS
        self.deaths = 0
        self._checked: set[str] = set()
        self._check: _Check | None = None
        self._look_now()
        if self._check is not None:
            self._check.thread.join(_CHECK_SECONDS)
            self._take_check()

    @property
    def count(self) -> int:
        """The number of workers that take tasks; 1 while there are none yet."""
        return max(1, self._working)

    @property
    def life_seconds(self) -> float | None:
        """Returns the lifetime of a worker, from the last ones that died; None if none has died."""
        if self.deaths == 0:
            return None
        lived = (self._marks[-1] - self._marks[0]) / (len(self._marks) - 1)
        return max(lived, self._worked_seconds - self._marks[-1])

    def look(self) -> bool:
        """Checks the workers from time to time; returns whether some have gone."""
        return clock() - self._seen >= LOOK_SECONDS and self._look_now()

    def _look_now(self) -> bool:
        now = clock()
        self._worked_seconds += (now - self._seen) * len(self._there)
        self._seen = now
        known = self._client.scheduler_info(n_workers=-1)["workers"]
        there = set(known)
        gone = self._there - there
        for _ in gone:
            self.deaths += 1
            self._marks.append(self._worked_seconds)
        self._there = there
        paused = sum(1 for one in known.values() if one.get("status") == "paused")
        self._working = len(there) - paused
        self._take_check()
        if self._check is None and not there <= self._checked:
            self._check = _Check(self._client, there - self._checked)
        self._mind_the_wait(now, paused)
        return bool(gone)

    def _mind_the_wait(self, now: float, paused: int) -> None:
        if self._working > 0:
            self._dry_since, self._told = None, QUIET_SECONDS
            return
        if self._dry_since is None:
            self._dry_since = now
        dry = now - self._dry_since
        why = f" that takes tasks ({paused} paused by Dask, since their memory is full)" if paused else ""
        nobody = f"no worker{why}" if paused else "no workers"
        if self._limit is not None and dry >= self._limit:
            raise ClusterError(f"{nobody} for {dry:.0f} s, which `workers_timeout` allows no longer; {self._where()}")
        if dry >= self._told:
            while self._told <= dry:
                self._told *= 2
            end = "" if self._limit is not None else ", and `workers_timeout` would end it"
            warnings.warn(
                f"{nobody} for {dry:.0f} s; {self._where()}; the print goes on once there are some{end}", PrintWarning,
                stacklevel=2,
            )

    def _take_check(self) -> None:
        """Handles the answers of new workers."""
        if self._check is None or self._check.thread.is_alive():
            return
        said, self._check = self._check.said, None
        for address, one in said.items():
            # Dask passes some exceptions on as their text.
            if isinstance(one, Exception) and ("ImportError" in repr(one) or "ModuleNotFoundError" in repr(one)):
                raise ClusterError(f"worker {address} cannot import OpenFab: {one}; install it as it is here")
            if isinstance(one, str):
                if one != worker.version():
                    raise ClusterError(
                        f"worker {address} has OpenFab {one}, this process {worker.version()}; install one version "
                        f"everywhere"
                    )
                self._checked.add(address)


class _Check:
    """Asks workers for their version, in a thread, since Dask waits half a minute for a worker that dies meanwhile."""

    def __init__(self, client: Any, addresses: set[str]) -> None:
        self.said: dict[str, Any] = {}
        self._client = client
        self._addresses = sorted(addresses)
        self.thread = threading.Thread(target=self._ask, daemon=True)
        self.thread.start()

    def _ask(self) -> None:
        try:
            self.said = self._client.run(worker.version, workers=self._addresses, on_error="return")
        except Exception:  # noqa: BLE001: they are asked again
            pass
