# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Results that a print is waiting for, from workers that may die at any time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent import futures as threads
from typing import Any

import distributed

from ..errors import Error, renamed
from . import cluster
from .worker import ClusterError, Failure, TaskError

# Of a result, before it is given up: its worker may die for reasons that are not its own. Dask counts to three between two of
# these.
_MOST_DEATHS = 5

_wait: Any = distributed.wait


class Wanted:
    """A result: one task, or two that compute the same.

    `submit` makes a task, whose key ends in its argument. `got` is the result once it has been fetched.
    """

    def __init__(self, what: str, end: int, submit: Callable[[str], Any]) -> None:
        self.end = end
        self.got: Any = None
        self._what = what
        self._submit = submit
        self.futures: list[Any] = [submit("")]
        self._fetching: threads.Future[Any] | None = None
        self._deaths = 0
        self._since: float | None = None

    @property
    def is_done(self) -> bool:
        """Whether nothing remains to be computed."""
        return self.is_fetched or self.is_being_fetched or self.is_finished

    @property
    def is_fetched(self) -> bool:
        """Whether the result has been fetched."""
        return self.got is not None

    @property
    def is_finished(self) -> bool:
        """Whether a worker has it."""
        return any(future.status == "finished" for future in self.futures)

    @property
    def is_being_fetched(self) -> bool:
        """Whether the result is being fetched."""
        return self._fetching is not None

    def waited(self) -> float:
        """Returns the seconds since the first call of this."""
        now = cluster.clock()
        self._since = now if self._since is None else self._since
        return now - self._since

    def again(self) -> None:
        """Submits the task a second time; the first result counts."""
        self.futures.append(self._submit("-again"))

    def drop(self) -> None:
        """Drops the tasks; the result is no longer needed."""
        for future in self.futures:
            future.release()
        self.futures = []

    def attend(self, client: Any, direct: bool, names: Mapping[str, str]) -> None:
        """Fetches a finished result without waiting; raises its error. `names` are names for messages."""
        if self.got is not None:
            return
        if self._fetching is None:
            self._mend()
            ready = next((future for future in self.futures if future.status == "finished"), None)
            if ready is None:
                return
            # It waits where the result is lost just now, so not in this thread.
            fetch = client.gather(ready, direct=direct, asynchronous=True)
            self._fetching = asyncio.run_coroutine_threadsafe(fetch, client.loop.asyncio_loop)
        if not self._fetching.done():
            return
        fetched, self._fetching = self._fetching, None
        try:
            result = fetched.result()
        except (distributed.KilledWorker, asyncio.CancelledError, threads.CancelledError, OSError) as error:
            self._count(error)  # what became of it is in its tasks
            return
        except Exception as error:
            raise self._failed(error) from error
        if isinstance(result, Failure):
            raise renamed(result.error, names)
        self.got = result
        self.drop()

    def _mend(self) -> None:
        """Resubmits tasks whose workers died; raises other errors."""
        for future in self.futures:
            if future.status == "cancelled":  # one that is lost is made again
                raise ClusterError("the cluster was closed or restarted while it printed")
            if future.status == "error":
                error = future.exception()
                if not isinstance(error, distributed.KilledWorker):
                    raise self._failed(error) from error
                self._count(error)
                future.retry()

    def _failed(self, error: BaseException) -> BaseException:
        if isinstance(error, Error):
            return error
        said = str(error) if isinstance(error, TaskError) else f"{type(error).__name__}: {error}"
        return ClusterError(f"a worker failed at {self._what}: {said}")

    def _count(self, error: BaseException) -> None:
        self._deaths += 1
        if self._deaths >= _MOST_DEATHS:
            raise ClusterError(
                f"workers that had {self._what} died again and again; perhaps they ran out of memory, which `memory` "
                f"limits"
            ) from error


def wait_for(wanted: Iterable[Wanted], seconds: float) -> None:
    """Waits for a limited time until something has happened to some results."""
    every = list(wanted)
    fetched = [one._fetching for one in every if one._fetching is not None]
    if fetched:
        threads.wait(fetched, seconds, threads.FIRST_COMPLETED)
        return
    tasks = [future for one in every for future in one.futures]
    if not tasks:
        time.sleep(0.05)
    elif not any(future.done() for future in tasks):
        try:
            _wait(tasks, timeout=seconds, return_when="FIRST_COMPLETED")
        except (TimeoutError, asyncio.TimeoutError, distributed.CancelledError):  # two kinds of it before Python 3.11
            pass
