# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints over workers that die, hang, fail or are missing end with the bytes of one process or a clear error."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import openfab

distributed = pytest.importorskip("distributed")
import dask  # noqa: E402

from openfab import distributed as over  # noqa: E402
from openfab.distributed import cluster, costs, printing, wanted  # noqa: E402
from openfab.distributed.inputs import Inputs  # noqa: E402


class Clock:
    """A clock that the test advances."""

    def __init__(self, step: float = 0) -> None:
        self.now = 0.0
        self._step = step

    def __call__(self) -> float:
        self.now += self._step
        return self.now


class Cluster:
    """The part of a client that is used to query its workers."""

    def __init__(self) -> None:
        self.workers: dict[str, dict[str, str]] = {}

    def scheduler_info(self, n_workers: int) -> dict[str, Any]:
        return {"workers": dict(self.workers)}

    def run(self, function: Any, workers: list[str], on_error: str) -> dict[str, Any]:
        return {address: openfab.__version__ for address in workers}


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(cluster, "clock", made)
    return made


def test_no_workers_for_half_a_minute_is_said_and_then_ever_more_rarely(clock: Clock) -> None:
    client = Cluster()
    workers = cluster.Workers(client, None, lambda: "56 of 480 slices are written")
    said = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for clock.now in range(1, 130):
            workers.look()
            said += [(clock.now, str(one.message)) for one in caught]
            caught.clear()
    assert [when for when, _ in said] == [30, 60, 120]
    assert said[0][1].startswith("no workers for 30 s; 56 of 480 slices are written; ")
    # One that comes ends the wait, and the next one is said again.
    client.workers["a"] = {"status": "running"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for clock.now in range(130, 300):
            workers.look()
        assert workers.count == 1
        client.workers = {"a": {"status": "paused"}}
        for clock.now in range(300, 329):
            workers.look()
    with pytest.warns(openfab.PrintWarning, match=r"1 paused by Dask, since their memory is full\) for 30 s"):
        clock.now = 330
        workers.look()


def test_a_wait_for_workers_has_a_limit(clock: Clock) -> None:
    workers = cluster.Workers(Cluster(), 20, lambda: "7 of 9 slices are written")
    clock.now = 19
    workers.look()
    clock.now = 20
    with pytest.raises(over.ClusterError, match="no workers for 20 s, .*`workers_timeout`.*; 7 of 9 slices"):
        workers.look()


def test_how_long_workers_live_is_told_by_the_last_that_died(clock: Clock) -> None:
    client = Cluster()
    client.workers = {"0": {}, "1": {}}
    workers = cluster.Workers(client, None, str)
    assert workers.life_seconds is None and costs.most_seconds(None) == costs.MOST_SECONDS

    def one_dies() -> None:
        names = sorted(map(int, client.workers))
        client.workers = {str(names[1]): {}, str(names[1] + 1): {}}

    clock.now = 1000
    one_dies()
    workers.look()
    assert workers.life_seconds == 2000
    for clock.now in (1005, 1010, 1015, 1020):
        one_dies()
        workers.look()
    # One of two every five seconds.
    assert workers.life_seconds == 10 and costs.most_seconds(10) == 1 and workers.deaths == 5
    clock.now = 1620
    workers.look()
    assert workers.life_seconds == 1200  # it is over


def test_shares_are_short_beside_the_life_of_a_worker() -> None:
    model = costs.CostModel(0, 1000)
    model.add(costs.ShareCost(0, 1, 0.3, 0.3, 1000))
    assert costs.share_end(model, 0, 1000, 1000, 1000, 2) == 33
    assert costs.share_end(model, 0, 1000, 1000, 1000, 2, costs.most_seconds(10)) == 3
    assert costs.share_end(model, 0, 1000, 1000, 1000, 2, costs.most_seconds(0.1)) == 1  # there is no less


@contextmanager
def workers_that(count: int, folder: Path, code: str, **options: Any) -> Iterator[Any]:
    """Starts a cluster whose workers run some code first; returns its client."""
    # Dask runs it more than once.
    (folder / "early.py").write_text(
        f"import pathlib\nfrom openfab.distributed import worker\nflag = pathlib.Path({str(folder / 'flag')!r})\n"
        f"worker.plain = getattr(worker, 'plain', None) or (worker.print_share, worker._ready)\n{code}"
    )
    with (
        distributed.LocalCluster(
            n_workers=count, threads_per_worker=1, dashboard_address=None, preload=[str(folder / "early.py")], **options
        ) as made,
        distributed.Client(made) as client,
    ):
        client.wait_for_workers(count)
        yield client


def same_bytes(world: openfab.World, client: Any, folder: Path, **options: Any) -> bool:
    """Returns whether a print over some workers has the bytes of one process."""
    openfab.print_world(world, folder / "alone.ofr", voxel=0.1)
    over.print_world(world, client, folder / "shared.ofr", voxel=0.1, **options)
    return (folder / "shared.ofr").read_bytes() == (folder / "alone.ofr").read_bytes()


def test_a_print_waits_for_workers_and_says_so(
    ball: openfab.World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (
        distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=None) as made,
        distributed.Client(made) as client,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("always")
        monkeypatch.setattr(cluster, "clock", Clock(step=16))
        said: list[str] = []

        def show(message: Warning | str, *_: Any) -> None:
            said.append(str(message))
            made.scale(1)

        monkeypatch.setattr(warnings, "showwarning", show)
        assert same_bytes(ball, client, tmp_path)
        assert re.match("no workers for [0-9]+ s; the print is not set up yet; the print goes on once there are", said[0])
        made.scale(0)
        while client.scheduler_info()["workers"]:
            time.sleep(0.05)
        with pytest.raises(over.ClusterError, match="`workers_timeout`"):
            over.print_world(ball, client, tmp_path / "x.ofr", voxel=0.5, workers_timeout=20)
        assert not (tmp_path / "x.ofr").exists()


def test_files_whose_workers_died_are_made_again_for_the_next_print(tmp_path: Path) -> None:
    """An earlier print failed, since workers that had its files died."""
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as made,
        distributed.Client(made) as client,
    ):
        (tmp_path / "flag").touch()
        printing._files[client] = failed = client.submit(dies_once, tmp_path / "flag", key="openfab-files-0")
        distributed.wait([failed])
        assert failed.status == "error"
        again = printing._send_files(client, Inputs("", b"", {}, (), "0", (), {}))
        assert again.result() == 3


def dies_once(flag: Path) -> int:
    if flag.exists():
        flag.unlink()
        os._exit(1)
    return 3


class Mortals:
    """Two workers without a nanny; ten are killed at random moments, many before they have started."""

    KILLS = 10

    def __init__(self, address: str, folder: Path, seed: int) -> None:
        self._words = [
            sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1",
            "--no-dashboard", "--local-directory", str(folder),
        ]
        self._chance = random.Random(seed)
        self._workers = [self._start(), self._start()]
        self._over = threading.Event()
        self._changed = threading.Condition()
        self.killed = 0
        self._thread = threading.Thread(target=self._kill)
        self._thread.start()

    def _start(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(self._words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def _kill(self) -> None:
        victim = 0
        for _ in range(self.KILLS):
            # Now one that has just been started, now one that has had time to print.
            starts = self._chance.random() < 0.4
            victim = victim if starts else self._chance.randrange(2)
            if self._over.wait(self._chance.uniform(0, 1) if starts else self._chance.uniform(1, 8)):
                return
            self._workers[victim].kill()
            self._workers[victim].wait()
            self._workers[victim] = self._start()
            with self._changed:
                self.killed += 1
                self._changed.notify_all()

    def wait_for_kills(self, count: int) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self.killed >= count)

    def end(self) -> None:
        self._over.set()
        self._thread.join()
        for worker in self._workers:
            worker.kill()
            worker.wait()


def test_ten_kills_at_random_moments_lose_nothing(gallery: Path, tmp_path: Path) -> None:
    world = openfab.load(gallery / "gyroid_block" / "gyroid.fab.json")
    openfab.print_world(world, tmp_path / "alone.ofr", draft=2)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=None) as made,
        distributed.Client(made) as client,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore", openfab.PrintWarning)  # there may be none for a while
        mortals = Mortals(made.scheduler_address, tmp_path, seed=12)

        def pace(done: int, total: int) -> None:
            # The print does not end before the kills.
            mortals.wait_for_kills(min(Mortals.KILLS, Mortals.KILLS * (done + 1) // total))

        try:
            done = over.print_world(world, client, tmp_path / "shared.ofr", draft=2, progress=pace)
        finally:
            mortals.end()
    assert mortals.killed == Mortals.KILLS and done.statistics["set_ups"] > 1
    assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()


HANGS = """
import threading
def hangs(job, first, end, *rest):
    if first == 0 and not flag.exists():
        flag.touch()
        threading.Event().wait()
    return worker.plain[0](job, first, end, *rest)
worker.print_share = hangs
"""


def test_the_lowest_share_is_sent_twice_when_a_worker_hangs(
    ball: openfab.World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(printing, "_LATE_SECONDS", 0)
    with workers_that(2, tmp_path, HANGS) as client:
        assert same_bytes(ball, client, tmp_path)
    assert (tmp_path / "flag").exists()


# Until the nanny ends the process, as it does where a print takes too much.
FILLS = """
import time
def fills(*arguments):
    if not flag.exists() or {always}:
        flag.touch()
        kept = []
        while True:
            kept.append(b"x" * 50_000_000)
            time.sleep(0.01)
    return worker.plain[1](*arguments)
worker._ready = fills
"""


@pytest.mark.parametrize("always", [False, True])
def test_a_worker_out_of_memory(
    ball: openfab.World, tmp_path: Path, always: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wanted, "_MOST_DEATHS", 1)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0 if always else 3}),
        workers_that(1, tmp_path, FILLS.format(always=always), memory_limit="1GB") as client,
    ):
        if always:
            with pytest.raises(over.ClusterError, match="the set-up died again and again; perhaps they ran out of memory"):
                over.print_world(ball, client, tmp_path / "shared.ofr", voxel=0.1)
            assert not (tmp_path / "shared.ofr").exists()
        else:
            assert same_bytes(ball, client, tmp_path)
    assert (tmp_path / "flag").exists()


RAISES = """
def raises(*arguments):
    if not flag.exists() or {always}:
        flag.touch()
        raise {error}
    return worker.plain[1](*arguments)
worker._ready = raises
"""


@pytest.mark.parametrize(
    ("always", "error", "text"),
    [
        (False, "RuntimeError('boom')", ""),
        (True, "RuntimeError('boom')", "a worker failed at the set-up: RuntimeError: boom"),
        (True, "MemoryError()", "a worker failed at the set-up: MemoryError"),
        (True, "type('Odd', (Exception,), {'__reduce__': lambda self: 1 / 0})('odd')", "a worker failed at the set-up: Odd: odd"),
        (True, "OSError(28, 'no space left')", "a worker failed at the set-up: .*no space left"),
    ],
)
def test_a_task_that_raises(ball: openfab.World, tmp_path: Path, always: bool, error: str, text: str) -> None:
    with workers_that(1, tmp_path, RAISES.format(always=always, error=error)) as client:
        if always:
            with pytest.raises(over.ClusterError, match=text):
                over.print_world(ball, client, tmp_path / "shared.ofr", voxel=0.1)
            assert not (tmp_path / "shared.ofr").exists()
        else:
            assert same_bytes(ball, client, tmp_path)
    assert (tmp_path / "flag").exists()
