# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The client's side of a print over many machines: it cuts, submits, takes in order, and writes."""

from __future__ import annotations

import json
import os
import time
import uuid
import warnings
import weakref
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future as Waiting
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any

import dask
import distributed

from .. import _files as own_files
from .._given import Real, Whole, whole
from .._options import words_of
from ..errors import InputError, PrintWarning, renamed
from ..printing import PrintInfo, PrintMaterial, Progress, _Bar, claim_threads
from ..world import AnyWorld, snapshot
from . import worker
from .costs import CostModel, ShareCost, sample_places, settled, share_end
from .inputs import Inputs, gather, printer_file
from .output import Output
from .worker import ClusterError, Failure, Job, Plan, Shared

# Of a share, before it is given up: its worker may die for reasons that are not its own.
_MOST_DEATHS = 10
_RETRIES = 3
# Shares that are printed or wait for their turn, for each worker.
_IN_FLIGHT = 3
_LOOK_SECONDS = 1.0

_wait: Any = distributed.wait


@dataclass(frozen=True)
class DistributedPrint:
    """A print that is complete. `statistics` has the keys of `--stats`, summed over the workers, and `costs` what each
    share took."""

    info: PrintInfo
    statistics: dict[str, Any]
    costs: tuple[ShareCost, ...]

    def save_costs(self, file: str | os.PathLike[str]) -> None:
        """Writes the costs as JSON, for bench/scale."""
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
    printer: str | os.PathLike[str] | None = None,
    voxel: Real | str | Sequence[Real] | None = None,
    dpi: Real | str | Sequence[Real] | None = None,
    layer: Real | str | None = None,
    draft: Whole | None = None,
    slices: Sequence[Whole] | None = None,
    z: Sequence[Real | str] | None = None,
    uniforms: Mapping[str, Any] | None = None,
    support: bool | str | None = None,
    dither: str | None = None,
    seed: Whole | None = None,
    crop: str | None = None,
    format: str | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
    token_file: str | os.PathLike[str] | None = None,
    tls_ca: str | os.PathLike[str] | None = None,
    in_flight: Whole | None = None,
    direct: bool = True,
    progress: Progress = False,
) -> DistributedPrint:
    """Prints a world on the workers of a Dask cluster; returns when the output is complete.

    >>> client = distributed.Client("tcp://scheduler:8786")                         # doctest: +SKIP
    >>> print_world(world, client, "s3://prints/ball.ofr", progress=True)           # doctest: +SKIP

    `out` is an .ofr file, a folder of slices, the address of a receiver, or a URL of fsspec (`memory://`, `s3://`) for
    a file or folder elsewhere; the bytes are those of `openfab.print_world`, whose arguments the others are. `memory`
    and `threads` are of each worker process; without them a print gets six tenths of what Dask gives the process, 1.5
    GB at most, and as many threads as Dask. At most `in_flight` shares are printed or wait to be written, 3 for each
    worker and 2 more unless given: a slow output holds the workers back. Slices come from the workers without passing
    through the scheduler, unless `direct` is False, for networks in which this process does not reach them.

    Workers that die are made up for. Raises ClusterError where the cluster cannot print, and what openfab.print_world
    raises.
    """
    began = time.monotonic()
    options = words_of(
        printer=printer, voxel=voxel, dpi=dpi, layer=layer, draft=draft, slices=slices, z=z, dither=dither, seed=seed,
        crop=crop, memory=memory, support=support,
    )
    receiver = words_of(format=format, token_file=token_file, tls_ca=tls_ca)
    threads, in_flight = _at_least_one(threads, "threads"), _at_least_one(in_flight, "in_flight")
    read = snapshot(world, uniforms)
    options += read.settings
    named = str(printer or read.description.get("printer") or "")
    if named.endswith(".json") and printer is None:
        named = os.path.join(read.path.parent, named)
    with Output(out, [*options, *receiver], named) as output:
        claim_threads()
        inputs = gather(read, options)
        workers = _Workers(client)
        job = Job(
            version=worker.version(), digest=inputs.digest, world=inputs.world, sources=inputs.sources,
            options=tuple(printer_file(options)), format=output.format, memory_given=memory is not None,
            threads=threads, made=str(own_files.folder()),
        )
        with _Run(client, workers, job, inputs, began, in_flight, direct, progress) as run:
            return run.print(output)


def _at_least_one(value: Whole | None, name: str) -> int | None:
    found = None if value is None else whole(value, f"`{name}`")
    if found is not None and found < 1:
        raise InputError(f"`{name}` cannot be {found}; it is 1 at least")
    return found


def release(client: distributed.Client) -> None:
    """Drops what workers keep of the last print for the next one: its files, kernels, meshes, trees."""
    _files.pop(client, None)
    client.run(worker.forget)


# The files of a client's last print, as a result that workers keep.
_files: weakref.WeakKeyDictionary[distributed.Client, Any] = weakref.WeakKeyDictionary()


def _send_files(client: distributed.Client, inputs: Inputs) -> Any:
    """Returns the files as a result of Dask's, which it moves to each worker once, and makes again where it is lost.

    They are a task's argument, not scattered: what is scattered is lost with the worker that has it.
    """
    key = f"openfab-files-{inputs.digest}"
    if client not in _files or _files[client].key != key or _files[client].status not in ("pending", "finished"):
        # Dask warns of large tasks; this one is meant.
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": 1 << 60}):
            _files[client] = client.submit(worker.hold, inputs.files, key=key, priority=1)
    return _files[client]


class _Workers:
    """The workers of a cluster, which may come and go; those that are new are asked which version they have.

    One that lacks the package cannot read a task; Dask drops it then, so that it is found here or not at all.
    """

    def __init__(self, client: distributed.Client) -> None:
        self._client: Any = client
        self._checked: set[str] = set()
        self._seen = -_LOOK_SECONDS
        self.look()

    def look(self) -> int:
        """Returns how many there are; looks for them, and at those that are new, now and then."""
        if time.monotonic() - self._seen >= _LOOK_SECONDS:
            self._seen = time.monotonic()
            addresses = set(self._client.scheduler_info(n_workers=-1)["workers"])
            self._check(addresses - self._checked)
            self._count = len(addresses)
        return max(1, self._count)

    def _check(self, addresses: set[str]) -> None:
        found = self._client.run(worker.version, workers=list(addresses), on_error="return") if addresses else {}
        for address, said in found.items():
            # Dask passes some exceptions on as their text.
            if isinstance(said, Exception) and ("ImportError" in repr(said) or "ModuleNotFoundError" in repr(said)):
                raise ClusterError(f"worker {address} cannot import OpenFab: {said}; install it as it is here")
            if isinstance(said, str):
                if said != worker.version():
                    raise ClusterError(
                        f"worker {address} has OpenFab {said}, this process {worker.version()}; install one version "
                        f"everywhere"
                    )
                self._checked.add(address)


class _Run:
    """One print. What is submitted is dropped when it ends."""

    def __init__(
        self, client: distributed.Client, workers: _Workers, job: Job, inputs: Inputs, began: float,
        in_flight: int | None, direct: bool, progress: Progress,
    ) -> None:
        self._client: Any = client
        self._workers = workers
        self._job = job
        self._began = began
        self._in_flight = in_flight
        self._direct = direct
        self._bar = _Bar(progress)
        self._name = uuid.uuid4().hex[:12]
        self._inputs = inputs
        self._shares: dict[int, tuple[int, Any]] = {}  # by first slab: end, result
        self._samples: dict[int, Any] = {}  # by slab: what it took, once it is known
        self._costs: list[ShareCost] = []
        self._statistics: dict[str, Any] = {}
        self._peak = 0
        self._set_ups = 0

    def __enter__(self) -> _Run:
        self._files = _send_files(self._client, self._inputs)
        self._world = self._client.submit(
            worker.hold, self._inputs.description, key=f"openfab-world-{self._name}", priority=1
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()
        # What nobody wants any more Dask drops; shares that are being printed end first.
        for future in (*(future for _, future in self._shares.values()), *self._samples.values(), self._world):
            future.release()
        self._shares, self._samples = {}, {}

    def print(self, output: Output) -> DistributedPrint:
        plan = self._set_up()
        for warning in plan.warnings:
            warnings.warn(warning, PrintWarning, stacklevel=4)
        output.open(plan, self._inputs.paths)
        self._plan = plan
        self._model = CostModel(*plan.slabs)
        self._cursor, self._end = plan.slabs
        self._places = sample_places(*plan.slabs, self._workers.look())
        for slab in self._places:
            printed = self._submit(slab, slab + 1)
            self._samples[slab] = self._client.submit(
                _cost_of, printed, key=f"openfab-cost-{self._name}-{slab}", priority=2
            )
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
        future = self._client.submit(
            worker.set_up, self._job, self._files, self._world, key=f"openfab-plan-{self._name}", priority=1,
            retries=_RETRIES,
        )
        plan: Plan = self._result(future, "the set-up")
        return plan

    def _submit(self, first: int, end: int) -> Any:
        future = self._client.submit(
            worker.print_share, self._job, first, end, self._files, self._world,
            key=f"openfab-share-{self._name}-{first}", priority=-first / self._end, retries=_RETRIES,
        )
        self._shares[first] = (end, future)
        return future

    def _fill(self) -> None:
        """Submits shares up to the number that may be in flight."""
        workers = self._workers.look()
        known = settled(self._places, self._samples, self._end)
        room = self._in_flight or _IN_FLIGHT * workers + 2
        ahead = sum(1 for first in self._shares if first < self._cursor)
        while self._cursor < self._end and ahead < room:
            if self._cursor in self._shares:
                self._cursor = self._shares[self._cursor][0]
                ahead += 1
                continue
            limit = min((first for first in self._shares if first > self._cursor), default=self._end)
            end = share_end(self._model, self._cursor, limit, known, self._end, workers)
            self._submit(self._cursor, end)
            self._cursor = end
            ahead += 1

    def _learn(self) -> bool:
        """Takes in what samples took that are done; returns whether anything is known."""
        done = [slab for slab, future in self._samples.items() if future.done()]
        good = [future for future in map(self._samples.pop, done) if future.status == "finished"]
        for cost in self._client.gather(good, errors="skip") if good else ():
            if cost is not None:
                self._model.add(cost)
        return self._model.is_known

    def _in_order(self) -> Iterator[Shared]:
        following = self._cursor
        while following < self._end:
            if self._learn():
                self._fill()
            end, future = self._shares[following]
            share: Shared = self._result(future, f"slices {8 * following} to {8 * end - 1}")
            if share.header != self._plan.header:
                raise ClusterError(
                    f"worker {share.cost.worker} prints something else of these files; install one version everywhere"
                )
            del self._shares[following], future
            self._account(share)
            following = end
            self._cursor = max(self._cursor, following)
            yield share

    def _wait_for(self, future: Any) -> None:
        """Waits for a result, and goes on handing out shares meanwhile."""
        while not future.done():
            try:
                _wait([future, *self._samples.values()], timeout=_LOOK_SECONDS, return_when="FIRST_COMPLETED")
            except TimeoutError:
                self._workers.look()
            if self._samples and self._learn():
                self._fill()

    def _result(self, future: Any, what: str) -> Any:
        for _ in range(_MOST_DEATHS):
            self._wait_for(future)
            try:
                result = self._client.gather(future, direct=self._direct)
            except distributed.KilledWorker:
                future.retry()
                continue
            except distributed.CancelledError as error:
                raise ClusterError("the cluster was closed or restarted while it printed") from error
            if isinstance(result, Failure):
                raise renamed(result.error, self._inputs.names)
            return result
        raise ClusterError(
            f"workers that had {what} died again and again; perhaps they ran out of memory, which `memory` limits"
        )

    def _account(self, share: Shared) -> None:
        cost = share.cost
        self._costs.append(cost)
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


def _cost_of(share: Shared | Failure) -> ShareCost | None:
    """What a sample took, without its slices; it runs where they are."""
    if isinstance(share, Failure):
        return None
    return share.cost
