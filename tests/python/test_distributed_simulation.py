# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The replay of prints on many workers, against closed forms."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

pytest.importorskip("distributed")

PROGRAM = ROOT / "bench" / "scale" / "simulate.py"


def load() -> Any:
    spec = importlib.util.spec_from_file_location("simulate", PROGRAM)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["simulate"] = module
    spec.loader.exec_module(module)
    return module


simulate = load()


@pytest.mark.parametrize(("workers", "fixed"), [(1, 0), (1, 3), (4, 1), (8, 2)])
def test_equal_slabs_take_what_they_take(workers: int, fixed: int) -> None:
    seconds, size = np.full(64, 2.0), np.full(64, 1e6)
    one = simulate.simulate(seconds, size, simulate.Place(workers, fixed=fixed))
    assert one.seconds == pytest.approx(2 * 64 / workers)
    assert one.efficiency == pytest.approx(1)


def test_set_up_counts_once_a_worker() -> None:
    one = simulate.simulate(np.full(40, 1.0), np.zeros(40), simulate.Place(4, set_up_seconds=5, fixed=1))
    assert one.seconds == pytest.approx(15) and one.efficiency == pytest.approx(40 / 60)


def test_more_workers_than_slabs_are_idle() -> None:
    one = simulate.simulate(np.full(10, 1.0), np.zeros(10), simulate.Place(100, fixed=1))
    assert one.seconds == pytest.approx(1) and one.efficiency == pytest.approx(0.1)
    assert one.bound(10, 100) == "too few slabs"


def test_the_output_is_a_bound_and_holds_the_rest_back() -> None:
    seconds, size = np.full(400, 1.0), np.full(400, 1e6)
    # Ten workers make 10 MB a second, and 2 MB leave.
    one = simulate.simulate(seconds, size, simulate.Place(10, bytes_per_second=2e6, fixed=1, in_flight=20))
    assert one.seconds == pytest.approx(400 * 1e6 / 2e6 + 1, rel=0.01)
    assert one.bound(400, 10) == "output" and one.most_held_bytes <= 20e6


def test_the_scheduler_is_a_bound() -> None:
    seconds = np.full(1000, 0.1)
    one = simulate.simulate(seconds, np.zeros(1000), simulate.Place(100, task_seconds=0.01, fixed=1))
    assert one.seconds == pytest.approx(1000 * 0.01 + 0.1, rel=0.02) and one.bound(1000, 100) == "scheduler"
    # Larger shares relieve it.
    larger = simulate.simulate(seconds, np.zeros(1000), simulate.Place(100, task_seconds=0.01, fixed=5))
    assert larger.seconds < 0.4 * one.seconds


def test_cuts_by_cost_beat_equal_ones_where_slabs_differ() -> None:
    # A tall print whose upper part is as costly as ten of the lower.
    seconds = np.concatenate([np.full(800, 0.02), np.full(80, 2.0)])
    size = np.full(880, 1e5)
    by_cost = simulate.simulate(seconds, size, simulate.Place(10, task_seconds=0.005))
    equal = simulate.simulate(seconds, size, simulate.Place(10, task_seconds=0.005, fixed=40))
    assert by_cost.efficiency > 0.85 > equal.efficiency


def test_shards_of_equal_parts_take_what_they_take() -> None:
    seconds, size = np.full(64, 2.0), np.full(64, 1e6)
    for parts in (0, 8):
        one = simulate.simulate_shards(seconds, size, simulate.Place(8, set_up_seconds=4), parts)
        assert one.seconds == pytest.approx(4 + 8 * 2.0) and one.efficiency == pytest.approx(16 / 20)
    # Two parts a worker are set up twice.
    one = simulate.simulate_shards(seconds, size, simulate.Place(8, set_up_seconds=4), 16)
    assert one.seconds == pytest.approx(2 * 4 + 8 * 2.0) and one.shares == 16


def test_parts_wait_for_the_slowest_and_slabs_do_not() -> None:
    seconds = np.concatenate([np.full(8, 1.0), np.full(8, 3.0)])
    place = simulate.Place(2)
    assert simulate.simulate_shards(seconds, np.zeros(16), place, 2).seconds == pytest.approx(24)
    assert simulate.simulate_shards(seconds, np.zeros(16), place).seconds == pytest.approx(16)


def test_all_who_write_share_the_store() -> None:
    # Four slabs at once, 1 MB each, at 2 MB/s together: 2 s; then the next four, as each has waited for its own.
    one = simulate.simulate_shards(np.full(8, 1.0), np.full(8, 1e6), simulate.Place(4, bytes_per_second=2e6))
    assert one.seconds == pytest.approx(1 + 2 + 1 + 2) and one.output_busy == pytest.approx(4 / 6)
    assert one.most_held_bytes == pytest.approx(4e6)
    # One alone has all of it: 1 s + 0.5 s, and a second that prints for 1.2 s then shares from there on.
    one = simulate.simulate_shards(np.array([1, 1.2]), np.full(2, 1e6), simulate.Place(2, bytes_per_second=2e6))
    assert one.seconds == pytest.approx(1 + 2e6 / 2e6)


def test_it_reads_what_a_print_wrote(tmp_path: Path) -> None:
    shares = [
        {"first": 5, "end": 7, "seconds": 3.0, "processor_seconds": 2.0, "bytes": 400, "worker": "a"},
        {"first": 7, "end": 8, "seconds": 9.0, "processor_seconds": 8.0, "bytes": 100, "worker": "b"},
    ]
    data = {"set_up_seconds": 0.5, "shares": shares}
    seconds, size = simulate.slabs_of(data)
    assert seconds.tolist() == [1, 1, 8] and size.tolist() == [200, 200, 100]
    seconds, size = simulate.slabs_of(data, slabs=6, times=10)
    assert seconds.tolist() == [10, 10, 10, 10, 80, 80]
    (tmp_path / "costs.json").write_text(json.dumps(data))
    said = subprocess.run(
        [sys.executable, str(PROGRAM), str(tmp_path / "costs.json"), "--workers", "1,2"], check=True,
        capture_output=True, text=True,
    ).stdout
    assert said.startswith("3 slabs, 10 s of a processor") and len(said.splitlines()) == 5
