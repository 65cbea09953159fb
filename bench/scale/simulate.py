#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Replays the costs of a print's shares on more workers than there are.

    bench/scale/simulate.py COSTS.json [--workers 10,100,1000] [--slabs N] [--times K] [--fixed N] …

COSTS.json is written by `DistributedPrint.save_costs`. The package's own code cuts the shares, or all have `--fixed`
slabs. Scheduler, link and writer are queues with one server each; a worker sets up before its first share.

With `--shards` there is no writer: workers write slabs into one store of Zarr, each before it goes on. `--parts` of the
print are cut as by `openfab print --part`, and taken in order, each by a process of its own; without them whoever is free takes
the next slab. The rate is that of the store, of which all who write have equal shares.
"""

from __future__ import annotations

import argparse
import heapq
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openfab.distributed.costs import CostModel, ShareCost, sample_places, settled, share_end


@dataclass(frozen=True)
class Place:
    """The machines on which a print runs."""

    workers: int
    set_up_seconds: float = 0.0
    task_seconds: float = 0.0
    """The scheduler's time per task."""
    bytes_per_second: float = float("inf")
    """The total rate from all workers to the output."""
    in_flight: int = 0
    """Shares at most; 0: three for each worker, and two more."""
    fixed: int = 0
    """Slabs of each share; 0: cut by what they take."""


@dataclass(frozen=True)
class Outcome:
    """The result of a print. Busy is the busy share of a server's time; efficiency is that of all workers."""

    seconds: float
    efficiency: float
    shares: int
    scheduler_busy: float
    output_busy: float
    most_held_bytes: float

    def bound(self, slabs: int, workers: int) -> str:
        """Returns the name of the bottleneck."""
        if self.output_busy > 0.9:
            return "output"
        if self.scheduler_busy > 0.9:
            return "scheduler"
        if self.efficiency > 0.9:
            return "workers"
        return "too few slabs" if slabs < 8 * workers else "set-up and tail"


def simulate(seconds: NDArray[np.float64], size: NDArray[np.float64], place: Place) -> Outcome:
    """Replays a print from the seconds and bytes of its slabs."""
    return _Replay(seconds, size, place).run()


def part_of(slabs: int, part: int, parts: int) -> tuple[int, int]:
    """Returns the slabs of a part, from 0, as `--part` cuts them."""
    return slabs * part // parts, slabs * (part + 1) // parts


def simulate_shards(seconds: NDArray[np.float64], size: NDArray[np.float64], place: Place, parts: int = 0) -> Outcome:
    """Replays a print whose workers write their own shards into one store.

    Parts are taken in order by whoever is free, and each is set up anew, as the tasks of a job array are. With 0 parts
    a worker is set up once, and takes slab by slab.
    """
    cut = [part_of(len(seconds), part, parts) for part in range(parts)] or [(slab, slab + 1) for slab in range(len(seconds))]
    waiting = [one for one in cut if one[0] < one[1]][::-1]
    shares = len(waiting)
    at: dict[int, tuple[int, int]] = {}  # of each worker its slab, and the end of its part
    printed: list[tuple[float, int]] = []

    def take(worker: int, now: float, is_first: bool) -> None:
        slab, end = at.get(worker, (0, 0))
        if slab == end:
            if not waiting:
                return
            slab, end = waiting.pop()
            now += place.set_up_seconds if is_first or parts else 0
        at[worker] = (slab, end)
        heapq.heappush(printed, (now + float(seconds[slab]), worker))

    for worker in range(place.workers):
        take(worker, 0, True)
    now = written = 0.0  # `written`: the bytes of one that has written from the beginning on
    writing: list[tuple[float, int]] = []  # at which value of `written` a worker's slab is there
    held = most_held = 0.0
    while printed or writing:
        rate = place.bytes_per_second / max(len(writing), 1)
        there = now + (writing[0][0] - written) / rate if writing else float("inf")
        then = min(there, printed[0][0] if printed else float("inf"))
        written += (then - now) * rate if writing and then > now else 0
        now = then
        if there <= now:
            written, worker = max(written, writing[0][0]), heapq.heappop(writing)[1]
            slab, end = at[worker]
            held -= float(size[slab])
            at[worker] = (slab + 1, end)
            take(worker, now, False)
        else:
            worker = heapq.heappop(printed)[1]
            made = float(size[at[worker][0]])
            heapq.heappush(writing, (written + made, worker))
            held += made
            most_held = max(most_held, held)
    total = float(seconds.sum())
    busy = float(size.sum()) / place.bytes_per_second / now
    return Outcome(now, total / (now * place.workers), shares, 0.0, busy, most_held)


class _Replay:
    def __init__(self, seconds: NDArray[np.float64], size: NDArray[np.float64], place: Place) -> None:
        self._seconds, self._size, self._place = seconds, size, place
        self._slabs = len(seconds)
        self._model = CostModel(0, self._slabs)
        self._room = place.in_flight or 3 * place.workers + 2
        self._now = 0.0
        self._events: list[tuple[float, int, int, str]] = []  # time, first slab, end, what
        self._queue: list[tuple[int, int]] = []
        self._cut: dict[int, int] = {}
        self._done: set[int] = set()
        self._idle = [(0.0, worker) for worker in range(place.workers)]
        self._of: dict[int, int] = {}
        self._cold = set(range(place.workers))
        self._scheduler_free = self._scheduler_work = 0.0
        self._output_free = self._output_work = 0.0
        self._next = self._cursor = 0
        self._unwritten: set[int] = set()
        self._samples: list[int] = []
        self._held = self._most_held = 0.0

    def run(self) -> Outcome:
        if not self._place.fixed:
            self._samples = sample_places(0, self._slabs, self._place.workers)
        for slab in self._samples:
            self._submit(slab, slab + 1)
        self._fill()
        while self._next < self._slabs:
            self._assign()
            self._now, first, end, what = heapq.heappop(self._events)
            if what == "printed":
                heapq.heappush(self._idle, (self._now, self._of.pop(first)))
                self._done.add(first)
                self._held += self._size[first:end].sum()
                self._most_held = max(self._most_held, self._held)
                took = float(self._seconds[first:end].sum())
                self._model.add(ShareCost(first, end, took, took, int(self._size[first:end].sum())))
            else:
                self._held -= self._size[first:end].sum()
                self._unwritten.remove(first)
                self._next = end
            if self._next < self._slabs and self._next in self._done and self._output_free <= self._now:
                self._write()
            self._fill()
        total = float(self._seconds.sum())
        return Outcome(
            self._now, total / (self._now * self._place.workers), len(self._cut), self._scheduler_work / self._now,
            self._output_work / self._now, self._most_held,
        )

    def _write(self) -> None:
        first, end = self._next, self._cut[self._next]
        took = self._size[first:end].sum() / self._place.bytes_per_second
        self._output_free = self._now + took
        self._output_work += took
        heapq.heappush(self._events, (self._output_free, first, end, "written"))

    def _submit(self, first: int, end: int) -> None:
        self._cut[first] = end
        self._unwritten.add(first)
        heapq.heappush(self._queue, (first, end))

    def _fill(self) -> None:
        known = settled(self._samples, [slab for slab in self._samples if slab not in self._done], self._slabs)
        while self._cursor < self._slabs:
            if self._cursor in self._cut:
                self._cursor = self._cut[self._cursor]
                continue
            ahead = sum(1 for first in self._unwritten if first < self._cursor)
            if ahead >= self._room or not (self._place.fixed or self._model.is_known):
                return
            if self._place.fixed:
                end = min(self._cursor + self._place.fixed, self._slabs)
            else:
                limit = min((first for first in self._cut if first > self._cursor), default=self._slabs)
                end = share_end(self._model, self._cursor, limit, known, self._slabs, self._place.workers)
            self._submit(self._cursor, end)

    def _assign(self) -> None:
        while self._queue and self._idle:
            first, end = heapq.heappop(self._queue)
            free, worker = heapq.heappop(self._idle)
            self._scheduler_free = max(self._scheduler_free, self._now, free) + self._place.task_seconds
            self._scheduler_work += self._place.task_seconds
            took = self._seconds[first:end].sum()
            if worker in self._cold:
                self._cold.remove(worker)
                took += self._place.set_up_seconds
            self._of[first] = worker
            heapq.heappush(self._events, (self._scheduler_free + took, first, end, "printed"))


def slabs_of(data: dict[str, Any], slabs: int = 0, times: float = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns seconds and bytes of each slab of a measured print, stretched to `slabs` and multiplied by `times`."""
    counted = [(one["end"] - one["first"], one) for one in data["shares"]]
    seconds, size = (
        np.concatenate([np.full(count, one[key] / count) for count, one in counted])
        for key in ("processor_seconds", "bytes")
    )
    if slabs:
        at = (np.arange(slabs) * len(seconds)) // slabs
        seconds, size = seconds[at], size[at]
    return times * seconds, times * size


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("costs", type=Path)
    parser.add_argument("--workers", default="1,10,100,1000")
    parser.add_argument("--slabs", type=int, default=0, help="stretch the print to so many slabs")
    parser.add_argument("--times", type=float, default=1, help="each as many times as costly, and as large")
    parser.add_argument("--set-up", type=float, help="seconds; the default is what was measured")
    parser.add_argument("--task", type=float, default=0.001, help="seconds of the scheduler for each task")
    parser.add_argument("--rate", type=float, default=500e6, help="bytes a second to the output")
    parser.add_argument("--in-flight", type=int, default=0)
    parser.add_argument("--fixed", type=int, default=0, help="slabs of each share")
    parser.add_argument("--shards", action="store_true", help="workers write their own shards into one store")
    parser.add_argument("--parts", type=int, default=0, help="with --shards: processes that each print a part")
    parser.add_argument("--bytes", type=float, default=1, help="each slab so many times as large, as in another format")
    words = parser.parse_args()
    data = json.loads(words.costs.read_text(encoding="utf-8"))
    seconds, size = slabs_of(data, words.slabs, words.times)
    size = size * words.bytes
    set_up = data["set_up_seconds"] if words.set_up is None else words.set_up
    total = f"{seconds.sum():.0f} s of a processor, {size.sum() / 1e6:.0f} MB"
    print(f"{len(seconds)} slabs, {total}, set-up {set_up:.2f} s")
    print("| workers | seconds | efficiency | shares | scheduler busy | output busy | held, MB | bound by |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for workers in map(int, words.workers.split(",")):
        place = Place(workers, set_up, words.task, words.rate, words.in_flight, words.fixed)
        one = simulate_shards(seconds, size, place, words.parts) if words.shards else simulate(seconds, size, place)
        print(
            f"| {workers} | {one.seconds:.1f} | {one.efficiency:.2f} | {one.shares} | {one.scheduler_busy:.2f} | "
            f"{one.output_busy:.2f} | {one.most_held_bytes / 1e6:.0f} | {one.bound(len(seconds), workers)} |"
        )


if __name__ == "__main__":
    main()
