# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from conftest import TOOL

import openfab


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    file = tmp_path / "machine.json"
    cost = {
        "currency": "CHF", "price_ml": {"white": 0.5, "*": 2}, "waste_ml_swath": 0.01, "swath_mm": 2, "passes": 2,
        "seconds_pass": 3, "seconds_layer": 5,
    }
    file.write_text(json.dumps({"cost": cost}))
    return file


def test_money_time_and_material_are_those_of_closed_forms(machine: Path) -> None:
    # 20 x 10 x 4 mm: 0.8 ml; 40 layers of 0.1 mm, 5 swaths of 2 passes in each.
    plain = """fablet Plain {
        @uniform { Material body; }
        @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(body, 1); return mc; }
    }"""
    white = openfab.Material("white", "#ffffff", density_g_cm3=1.5)
    world = openfab.World()
    world.add(openfab.box(20, 10, 4), openfab.Fablet(text=plain), {"body": white})
    found = openfab.estimate(world, process=machine, voxel=0.1, support=False)
    assert found.slices == 40
    assert found.voxels == 200 * 100 * 40
    assert found.passes == 400
    assert found.currency == "CHF"
    one = found["white"]
    assert one.ml == pytest.approx(0.8, rel=0.03)
    assert one.g == pytest.approx(1.5 * one.ml)
    assert one.waste_ml == pytest.approx(4.0)
    assert one.money == pytest.approx(0.5 * (one.ml + one.waste_ml))
    assert found.money == pytest.approx(one.money)
    assert found.print_seconds == pytest.approx(400 * 3 + 40 * 5)
    assert found.seconds > 0
    assert found.memory_bytes > 1_000_000
    with pytest.raises(KeyError):
        found["black"]


def test_it_is_what_the_tool_tells(gallery: Path, machine: Path, tmp_path: Path) -> None:
    file = gallery / "gyroid_block" / "gyroid.fab.json"
    found = openfab.estimate(openfab.load(file), process=machine, draft=4)
    stats = tmp_path / "stats.json"
    command = [TOOL, "print", file, "--estimate", "--draft", "4", "--process", machine, "--stats", stats]
    subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=600)
    told = json.loads(stats.read_text())
    # How coarse the print is that amounts come from depends on how quick the machine is at the time.
    assert {one.name: one.ml for one in found.materials} == pytest.approx(told["ml_by_material"], rel=0.05)
    assert found.money == pytest.approx(told["cost"]["money"], rel=0.05)
    assert found.print_seconds == pytest.approx(told["cost"]["seconds"])
    assert found.slices == told["slices"]


def test_without_prices_there_is_no_money(ball: openfab.World) -> None:
    found = openfab.estimate(ball, draft=4)
    assert found.money is None
    assert found.currency is None
    assert found["white"].money is None
    assert found["white"].ml > 0


def test_the_process_of_a_print_is_an_argument(ball: openfab.World, tmp_path: Path) -> None:
    scaled = tmp_path / "scaled.json"
    scaled.write_text('{"scale": 1.5}')
    plain, larger = (openfab.print_world(ball, draft=4, process=one).info.size for one in (None, scaled))
    assert larger[0] == pytest.approx(1.5 * plain[0], abs=1)
