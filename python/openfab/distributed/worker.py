# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The tasks of workers. A process keeps the set-up of the last print: kernels, meshes, trees."""

from __future__ import annotations

import functools
import hashlib
import json
import shutil
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import distributed

from .. import _core
from .._options import options_of
from .._snapshot import dither_rule
from ..errors import Error, InputError, InternalError, OutsideError, raise_error, renamed
from ..fablet import programs
from ..printing import claim_threads
from .costs import ShareCost
from .inputs import Blob, unpack

P = ParamSpec("P")
T = TypeVar("T")


class ClusterError(OutsideError):
    """The cluster cannot print: workers lack the package, have another version of it, or keep dying."""


@dataclass(frozen=True)
class Job:
    """The description of a print for a worker, without the files."""

    version: str
    digest: str
    """Of the files; they are unpacked once."""
    world: str
    sources: tuple[str, ...]
    fields: dict[str, Any]
    """Of Options."""
    format: str
    threads: int | None
    made: str
    """The client's folder of its own files, for messages."""


@dataclass(frozen=True)
class Plan:
    """The description of a print that has been set up."""

    header: bytes
    info: dict[str, Any]
    slabs: tuple[int, int]
    warnings: tuple[str, ...]
    part_sizes: str


@dataclass
class Shared:
    """A printed share. `header` identifies its print."""

    header: bytes
    slices: Blob
    lengths: list[int]
    totals: _core.Totals
    statistics: dict[str, Any]
    cost: ShareCost


@dataclass(frozen=True)
class Failure:
    """An error that every worker would have, so that Dask must not try again."""

    error: Error


@dataclass
class _Kept:
    key: tuple[Any, ...]
    printer: _core.SharePrinter
    header: bytes
    work: dict[str, Any] = field(default_factory=dict)


_lock = threading.Lock()
_kept: _Kept | None = None

# Of the budget of a process that Dask gives it; the rest is for what travels, and for Python.
_SHARE_OF_MEMORY = 0.6
_USUAL_MEMORY = 1_500_000_000


def version() -> str:
    """Returns the version of the package on a worker."""
    import openfab

    return openfab.__version__


def hold(thing: T) -> T:
    """Returns its argument, as a result that Dask moves between workers and makes again if it is lost."""
    return thing


def forget() -> None:
    """Drops the set-up of the last print."""
    global _kept
    with _lock:
        _kept = None


class TaskError(Exception):
    """The exception of a task as text; Dask never reports a failure whose exception or traceback cannot be sent."""


def _report(task: Callable[P, T]) -> Callable[P, T | Failure]:
    """Returns input errors instead of raising them; Dask tries again after other errors, perhaps on another worker."""

    @functools.wraps(task)
    def reported(*args: P.args, **kwargs: P.kwargs) -> T | Failure:
        try:
            return task(*args, **kwargs)
        except (InputError, InternalError, ClusterError) as error:
            return Failure(error)
        except Error:
            raise
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
        raise TaskError(said)

    return reported


@_report
def set_up(job: Job, inputs: dict[str, Blob], description: bytes) -> Plan:
    """Sets up a print; returns its description."""
    with _lock:
        kept = _ready(job, inputs, description)
        return Plan(
            kept.header, kept.printer.info, kept.printer.slabs, tuple(kept.printer.warnings), kept.printer.part_sizes
        )


@_report
def print_share(job: Job, first: int, end: int, inputs: dict[str, Blob], description: bytes) -> Shared:
    """Prints slabs [first, end)."""
    with _lock:
        kept = _ready(job, inputs, description)
        share = kept.printer.print(first, end)
        if isinstance(share, _core.Error):
            raise_error(share)
        statistics = json.loads(share.statistics)
        now = {key: statistics[key] for key in WORK}
        done, kept.work = difference(now, kept.work), now
        statistics.update(done)
        slices = share.take_bytes()
        cost = ShareCost(
            first, end, share.seconds, share.processor_seconds, slices.nbytes, distributed.get_worker().address
        )
        return Shared(kept.header, slices, list(share.lengths), share.totals, statistics, cost)


# What statistics sum up over the shares of one process.
WORK = (
    "seconds_by_phase", "blocks", "queries", "cache", "weights_not_usable", "displacements_not_finite",
    "displacements_cut",
)


def difference(now: Any, before: Any) -> Any:
    """Returns the increase of counters; a peak is kept."""
    if not isinstance(now, dict):
        return now - (before or 0)
    before = before or {}
    return {key: value if key == "peak_bytes" else difference(value, before.get(key)) for key, value in now.items()}


def total(one: Any, other: Any) -> Any:
    """Returns the sum of two sets of counters."""
    if not isinstance(one, dict):
        return one + other
    return {
        key: max(value, other[key]) if key == "peak_bytes" else total(value, other[key]) for key, value in one.items()
    }


def _ready(job: Job, inputs: dict[str, Blob], description: bytes) -> _Kept:
    global _kept
    if job.version != version():
        raise ClusterError(
            f"worker {distributed.get_worker().address} has OpenFab {version()}, this process {job.version}; install "
            f"one version everywhere"
        )
    key = (job, hashlib.sha256(description).hexdigest())
    if _kept is None or _kept.key != key:
        _kept = None  # its memory is wanted
        root = _folder(job.digest)
        try:
            _kept = _set_up(job, key, root, inputs, description)
        except Error as error:
            raise renamed(error, {f"{root}/files": "", f"{root}/made": job.made}) from None
    return _kept


def _folder(digest: str) -> Path:
    """Returns the folder for the files of a digest; folders of others are removed."""
    parent = Path(distributed.get_worker().local_directory) / "openfab"
    folder = parent / digest
    if parent.is_dir() and not folder.is_dir():
        shutil.rmtree(parent)
    return folder


def _set_up(job: Job, key: tuple[Any, ...], root: Path, inputs: dict[str, Blob], description: bytes) -> _Kept:
    claim_threads()
    world = unpack(root, inputs, job.world, description)
    named = {"input": str(world), "allow": [str(root), *job.fields["allow"]]}
    rule = dither_rule(options_of(named))
    program, _ = programs.find([root / source for source in job.sources], rule=rule)
    worker = distributed.get_worker()
    fields = {**job.fields, **named, "threads": job.threads or worker.state.nthreads}
    if fields["printer"].startswith("files/"):
        fields["printer"] = str(root / fields["printer"])
    if "memory_bytes" not in fields:
        limit = worker.memory_manager.memory_limit or _USUAL_MEMORY / _SHARE_OF_MEMORY
        fields.update(memory_bytes=int(min(_USUAL_MEMORY, _SHARE_OF_MEMORY * limit)), memory_given=True)
    printer = _core.set_up_shares(program, options_of(fields), job.format)
    if isinstance(printer, _core.Error):
        raise_error(printer)
    return _Kept(key, printer, printer.header)

