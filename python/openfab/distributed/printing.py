# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The client's side of a print over many machines: it cuts and submits shares, and writes them in order."""

from __future__ import annotations

import inspect
import json
import os
import time
import uuid
import warnings
import weakref
from collections.abc import Iterator, Mapping
from concurrent.futures import Future as Waiting
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import dask
import distributed

from .. import _files as own_files
from .. import printing as _printing
from .._given import Real, Whole, number, whole
from .._options import SharedArguments, fields_of
from .._progress import Bar, Progress
from ..errors import Error, InputError, PrintWarning
from ..printing import claim_threads
from ..slices import PrintInfo, PrintMaterial
from ..world import AnyWorld, snapshot
from . import worker
from .cluster import LOOK_SECONDS, Workers
from .costs import MOST_SECONDS, CostModel, ShareCost, most_seconds, sample_places, settled, share_end
from .inputs import Inputs, gather, of_workers
from .output import Output
from .wanted import Wanted, wait_for
from .worker import ClusterError, Failure, Job, Plan, Shared

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Of a task that fails, by itself: a full disk, say. Deaths of workers are counted apart.
_RETRIES = 3
# Shares that are printed or wait for their turn, for each worker.
_IN_FLIGHT = 3
# Of a share that takes longer the worker may hang: twice what one is to take, and three times what the longest has taken.
_LATE_SECONDS = 2 * MOST_SECONDS
_LATE_TIMES = 3
# Of slices that wait in this process for those below them.
_AHEAD_BYTES = 64_000_000


@dataclass(frozen=True)
class DistributedPrint:
    """A complete print over many machines.

    Attributes
    ----------
    info : PrintInfo
        The grid and the materials.
    statistics : dict
        The keys of `--stats`, summed over the workers.
    costs : tuple of ShareCost
        The cost of each share.
    """

    info: PrintInfo
    statistics: dict[str, Any]
    costs: tuple[ShareCost, ...]

    def save_costs(self, file: str | os.PathLike[str]) -> None:
        """Writes the costs as JSON, for bench/scale.

        Parameters
        ----------
        file : str or path
            The file to write.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        data = {
            "title": self.info.title,
            "size": self.info.size,
            "seconds": self.statistics["seconds_total"],
            "set_up_seconds": self.statistics["seconds_by_phase"]["set_up"] / max(1, self.statistics["set_ups"]),
            "inputs_bytes": self.statistics["inputs_bytes"],
            "shares": [asdict(one) for one in self.costs],
        }
        with open(file, "w", encoding="utf-8") as out:
            json.dump(data, out, indent=1)


def print_world(
    world: AnyWorld,
    client: distributed.Client,
    out: str | os.PathLike[str],
    *,
    uniforms: Mapping[str, Any] | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
    in_flight: Whole | None = None,
    workers_timeout: Real | None = None,
    direct: bool = True,
    progress: Progress = False,
    **arguments: Unpack[SharedArguments],
) -> DistributedPrint:
    """Prints a world on the workers of a Dask cluster; returns when the output is complete.

    The output has the same bytes as that of `openfab.print_world`. The work of a worker that dies is repeated elsewhere.
    After 30 s without any worker, a PrintWarning reports the progress of the print.

    Parameters
    ----------
    world : World or FileWorld
        What to print, in its state at the call.
    client : distributed.Client
        The client of the cluster.
    out : str or path
        An .ofr file, a folder of slices, the address of a receiver, or a URL of fsspec (`memory://`, `s3://`) for a file or
        a folder elsewhere.
    printer, voxel, dpi, layer, draft, slices, z, uniforms, support, dither, seed, crop, format, token_file, tls_ca
        The same as for `openfab.print_world`; lengths are in mm.
    memory : int or str, optional
        The budget of each worker process, in bytes. Default: six tenths of Dask's limit, at most 1.5 GB.
    threads : int, optional
        The threads of each worker process. Default: as many as Dask's.
    in_flight : int, optional
        The number of shares that are being printed or wait to be written, at least 1. Default: 3 for each worker, plus 2.
        It holds workers back if the output is slow.
    workers_timeout : float, optional
        Seconds without any worker after which the print fails. Default: it waits until there are some.
    direct : bool, optional
        Whether slices come directly from the workers and not through the scheduler. Use False if this process cannot reach
        the workers over the network.
    progress : bool or callable, optional
        True for a progress bar, or a function that takes the number of finished slices and of all slices.

    Returns
    -------
    DistributedPrint
        The statistics, and the cost of each share.

    Raises
    ------
    ClusterError
        If the cluster cannot print: another version of the package, workers that keep dying, a task that fails, or no
        workers for longer than `workers_timeout`.
    InputError, CompileError, OutsideError
        The same as for `openfab.print_world`.

    Examples
    --------
    >>> client = distributed.Client("tcp://scheduler:8786")                         # doctest: +SKIP
    >>> print_world(world, client, "s3://prints/ball.ofr", progress=True)           # doctest: +SKIP
    """
    began = time.monotonic()
    unknown = arguments.keys() - SharedArguments.__annotations__.keys()
    if unknown:
        raise TypeError(f"print_world() got an unexpected keyword argument {min(unknown)!r}")
    every = fields_of(**arguments, memory=memory)
    limit = None if workers_timeout is None else number(workers_timeout, "`workers_timeout`")
    threads, in_flight = _at_least_one(threads, "threads"), _at_least_one(in_flight, "in_flight")
    read = snapshot(world, uniforms)
    every["settings"] = list(read.settings)
    named = every.get("printer") or str(read.description.get("printer") or "")
    if named.endswith(".json") and "printer" not in every:
        named = os.path.join(read.path.parent, named)
    with Output(out, every, named) as output:
        claim_threads()
        fields = {key: value for key, value in every.items() if key not in ("format", "token_file", "tls_ca")}
        inputs = gather(read, fields)
        job = Job(
            version=worker.version(), digest=inputs.digest, world=inputs.world, sources=inputs.sources,
            fields=of_workers(read, fields), format=output.format, threads=threads, made=str(own_files.folder()),
        )
        with _Run(client, limit, job, inputs, began, in_flight, direct, progress) as run:
            return run.print(output)


def _signature() -> inspect.Signature:
    """Returns the signature of print_world for help and notebooks, including shared arguments."""
    own = inspect.signature(print_world)
    shared = inspect.signature(_printing.print_world).parameters
    *mine, _ = own.parameters.values()
    first = next(place for place, one in enumerate(mine) if one.kind is one.KEYWORD_ONLY)
    mine[first:first] = [shared[name] for name in SharedArguments.__annotations__]
    return own.replace(parameters=mine)


print_world.__signature__ = _signature()  # type: ignore[attr-defined]


def _at_least_one(value: Whole | None, name: str) -> int | None:
    found = None if value is None else whole(value, f"`{name}`")
    if found is not None and found < 1:
        raise InputError(f"`{name}` cannot be {found}; it is 1 at least")
    return found


def release(client: distributed.Client) -> None:
    """Drops the files, kernels, meshes and trees that workers keep from the last print for the next one.

    Parameters
    ----------
    client : distributed.Client
        The client of the cluster.

    Raises
    ------
    Exception
        Dask's exception if a worker cannot be reached.
    """
    _files.pop(client, None)
    client.run(worker.forget)


# The files of a client's last print, as a result that workers keep.
_files: weakref.WeakKeyDictionary[distributed.Client, Any] = weakref.WeakKeyDictionary()


def _send_files(client: distributed.Client, inputs: Inputs) -> Any:
    """Returns the files as a Dask result, which is moved to each worker once, and made again if it is lost.

    They are the argument of a task. Scattered data would be lost with the worker that holds them.
    """
    key = f"openfab-files-{inputs.digest}"
    known = _files.get(client)
    if known is not None and known.key == key and known.status == "error":
        known.retry()  # workers that had it died, of an earlier print; submitted again, it would stay what it is
    elif known is None or known.key != key or known.status == "cancelled":
        # Dask warns of large tasks; this one is meant.
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": 1 << 60}):
            _files[client] = client.submit(worker.hold, inputs.files, key=key, priority=1)
    return _files[client]


class _Run:
    """One print. Its submitted tasks are dropped when it ends."""

    def __init__(
        self, client: distributed.Client, limit: float | None, job: Job, inputs: Inputs, began: float,
        in_flight: int | None, direct: bool, progress: Progress,
    ) -> None:
        self._client: Any = client
        self._job = job
        self._began = began
        self._in_flight = in_flight
        self._direct = direct
        self._bar = Bar(progress)
        self._name = uuid.uuid4().hex[:12]
        self._inputs = inputs
        self._shares: dict[int, Wanted] = {}  # by first slab
        self._samples: dict[int, Wanted] = {}  # by slab: what it took, once it is known
        self._processing: set[str] = set()  # what workers had when they were looked at last, once one has died
        self._costs: list[ShareCost] = []
        self._statistics: dict[str, Any] = {}
        self._peak = 0
        self._longest = 0.0
        self._set_ups = 0
        self._output: Output | None = None
        self._workers = Workers(client, limit, self.where)

    def __enter__(self) -> _Run:
        self._files = _send_files(self._client, self._inputs)
        self._world = self._client.submit(
            worker.hold, self._inputs.description, key=f"openfab-world-{self._name}", priority=1
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()
        # What nobody wants any more Dask drops; shares that are being printed end first.
        for wanted in (*self._shares.values(), *self._samples.values()):
            wanted.drop()
        self._world.release()
        self._shares, self._samples = {}, {}

    def where(self) -> str:
        """Returns a text about the progress."""
        if self._output is None:
            return "the print is not set up yet"
        first, end = self._plan.info["slices"]
        return f"{self._output.next_slice - first} of {end - first} slices are written"

    def print(self, output: Output) -> DistributedPrint:
        plan = self._set_up()
        for warning in plan.warnings:
            warnings.warn(warning, PrintWarning, stacklevel=4)
        output.open(plan, self._inputs.paths)
        self._plan = plan
        self._output = output
        self._model = CostModel(*plan.slabs)
        self._cursor, self._end = plan.slabs
        self._places = sample_places(*plan.slabs, self._workers.count)
        for slab in self._places:
            self._samples[slab] = self._sample(slab)
        first, end = plan.info["slices"]
        seconds_first = 0.0
        with ThreadPoolExecutor(1, "openfab-writer") as pool:
            writing: Waiting[None] | None = None
            for share in self._in_order():
                if writing is not None:
                    writing.result()
                    seconds_first = seconds_first or time.monotonic() - self._began
                    self._bar.show(output.next_slice - first, end - first)
                writing = pool.submit(output.write, share)
            if writing is not None:
                writing.result()
        statistics = output.finish()
        self._bar.show(end - first, end - first)
        return self._complete(statistics, seconds_first)

    def _set_up(self) -> Plan:
        def submit(again: str) -> Any:
            return self._client.submit(
                worker.set_up, self._job, self._files, self._world, key=f"openfab-plan-{self._name}{again}", priority=1,
                retries=_RETRIES,
            )

        wanted = Wanted("the set-up", 0, submit)
        while not self._has(wanted):
            self._help(wanted)
            self._wait([wanted])
        plan: Plan = wanted.got
        return plan

    def _has(self, wanted: Wanted) -> bool:
        wanted.attend(self._client, self._direct, self._inputs.names)
        return wanted.got is not None

    def _submit(self, first: int, end: int) -> Wanted:
        def submit(again: str) -> Any:
            return self._client.submit(
                worker.print_share, self._job, first, end, self._files, self._world,
                key=f"openfab-share-{self._name}-{first}-{end}{again}", priority=-first / self._end, retries=_RETRIES,
            )

        share = Wanted(f"slices {8 * first} to {8 * end - 1}", end, submit)
        self._shares[first] = share
        return share

    def _sample(self, slab: int) -> Wanted:
        (printed,) = self._submit(slab, slab + 1).futures
        key = f"openfab-cost-{self._name}-{slab}"
        return Wanted("a sample", 0, lambda again: self._client.submit(_cost_of, printed, key=key + again, priority=2))

    def _fill(self) -> None:
        """Submits shares up to the limit of shares in flight."""
        workers = self._workers.count
        room = self._in_flight or _IN_FLIGHT * workers + 2
        ahead = sum(1 for first in self._shares if first < self._cursor)
        while self._cursor < self._end and ahead < room:
            if self._cursor in self._shares:
                self._cursor = self._shares[self._cursor].end
                ahead += 1
                continue
            limit = min((first for first in self._shares if first > self._cursor), default=self._end)
            end = self._share_end(self._cursor, limit)
            self._submit(self._cursor, end)
            self._cursor = end
            ahead += 1

    def _share_end(self, first: int, limit: int) -> int:
        known = settled(self._places, self._samples, self._end)
        most = most_seconds(self._workers.life_seconds)
        return share_end(self._model, first, limit, known, self._end, self._workers.count, most)

    def _cut_again(self, busy: set[str]) -> None:
        """Cuts shares that were submitted before workers died into shorter ones, except those that a worker is printing."""
        for first, share in sorted(self._shares.items()):
            if share.is_done or any(str(future.key) in busy for future in share.futures):
                continue
            at, end = first, share.end
            if self._share_end(at, end) == end:
                continue
            share.drop()
            while at < end:
                piece = self._share_end(at, end)
                self._submit(at, piece)
                at = piece

    def _learn(self) -> bool:
        """Adds the costs of finished samples; returns whether any cost is known."""
        for slab, sample in list(self._samples.items()):
            try:
                has = self._has(sample)
            except Error:  # which its share has, too
                has = True
            if has:
                del self._samples[slab]
                if isinstance(sample.got, ShareCost):
                    self._model.add(sample.got)
        return self._model.is_known

    def _in_order(self) -> Iterator[Shared]:
        following = self._cursor
        while following < self._end:
            share = self._take(following)
            if share.header != self._plan.header:
                raise ClusterError(
                    f"worker {share.cost.worker} prints something else of these files; install one version everywhere"
                )
            self._account(share)
            following = share.cost.end
            self._cursor = max(self._cursor, following)
            yield share

    def _take(self, first: int) -> Shared:
        """Waits for a share; meanwhile submits others and fetches finished ones."""
        while True:
            if self._learn():
                self._fill()
            wanted = self._shares[first]
            if self._has(wanted):
                share: Shared = self._shares.pop(first).got
                return share
            self._help(wanted)
            self._wait([wanted, *self._fetch_ahead(first)])

    def _fetch_ahead(self, first: int) -> list[Wanted]:
        """Fetches finished shares early, since their workers may die; returns those on their way."""
        held = sum(share.got.cost.bytes for share in self._shares.values() if share.got is not None)
        for place, share in sorted(self._shares.items()):
            if place == first or share.is_fetched or not share.is_done:
                continue
            if held >= _AHEAD_BYTES:
                break
            if not self._has(share):
                return [share]
            fetched: Shared = share.got
            held += fetched.cost.bytes
        return []

    def _help(self, wanted: Wanted) -> None:
        """Submits a share that blocks the output once more, if workers have died and others are idle, or if it takes very long."""
        if wanted.is_done or len(wanted.futures) > 1:
            return
        slow = wanted.waited() > max(_LATE_SECONDS, _LATE_TIMES * self._longest)
        busy = sum(1 for one in {wanted, *self._shares.values()} if not one.is_done)
        if slow or self._workers.deaths and busy < self._workers.count:
            wanted.again()

    def _wait(self, wanted: list[Wanted]) -> None:
        """Waits a limited time until something has happened, and checks the workers."""
        wait_for([*wanted, *self._samples.values()], LOOK_SECONDS)
        deaths = self._workers.deaths
        if not self._workers.look() or self._workers.deaths == 0:
            return
        now = {str(key) for keys in self._client.processing().values() for key in keys}
        if self._workers.deaths > deaths:
            # What was with a worker that is dead may be with another by now, which has hardly begun.
            self._cut_again(now & self._processing)
        self._processing = now

    def _account(self, share: Shared) -> None:
        cost = share.cost
        self._costs.append(cost)
        self._longest = max(self._longest, cost.seconds)
        self._model.add(cost)
        self._set_ups += share.statistics["seconds_by_phase"]["set_up"] > 0
        self._peak = max(self._peak, share.statistics["peak_rss_bytes"])
        work = {key: share.statistics[key] for key in worker.WORK}
        self._statistics = worker.total(work, self._statistics) if self._statistics else work

    def _complete(self, statistics: dict[str, Any], seconds_first: float) -> DistributedPrint:
        seconds = time.monotonic() - self._began
        statistics.update(self._statistics)
        statistics.update(
            seconds_total=seconds, seconds_first_slice=seconds_first or seconds, peak_rss_bytes=self._peak,
            mvoxels_per_second=statistics["voxels_total"] / seconds / 1e6,
            msolid_per_second=statistics["voxels_solid"] / seconds / 1e6,
            processor_seconds=sum(cost.processor_seconds for cost in self._costs),
            shares=len(self._costs), set_ups=self._set_ups, inputs_bytes=self._inputs.bytes,
            warnings=list(self._plan.warnings),
        )
        if statistics["voxels_solid"] == 0:
            nothing = f"nothing was printed: no voxel has any material; {self._plan.part_sizes}"
            statistics["warnings"].append(nothing)
            warnings.warn(nothing, PrintWarning, stacklevel=4)
        data = dict(self._plan.info)
        data["materials"] = tuple(PrintMaterial(**one) for one in data["materials"])
        return DistributedPrint(PrintInfo(**data), statistics, tuple(self._costs))


def _cost_of(share: Shared | Failure) -> ShareCost | Failure:
    """Returns the cost of a sample without its slices; runs on the worker that holds them."""
    return share if isinstance(share, Failure) else share.cost
