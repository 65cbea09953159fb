# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the Python package's tests: the repository's worlds, and the programs as a reference."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Callable

import pytest

import openfab

ROOT = Path(__file__).resolve().parents[2]
TOOL = Path(os.environ.get("OPENFAB_TOOL", ROOT / "build" / "release" / "bin" / "openfab"))

BALL = """fablet Ball {
    @uniform { float skin = 0.5 [[ float min = 0, string help = "thickness of the skin, mm" ]]; Material core, shell; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin);
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
"""

BY_VOLUME = """fablet ByVolume {
    @uniform { ImageTexture3D field; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = field.Sample1(attr.voxelCenter, 0, 0);
        mc.Set(one, t);
        mc.Set(other, 1 - t);
        return mc;
    }
}
"""


@pytest.fixture
def gallery() -> Path:
    return ROOT / "gallery"


@pytest.fixture
def ball() -> openfab.World:
    """A small ball of two materials."""
    world = openfab.World(printer="generic", title="ball")
    world.add(
        openfab.sphere(6),
        openfab.Fablet(text=BALL, label="ball.fl"),
        {"core": openfab.Material("white", "#ffffff"), "shell": openfab.Material("black", "#000000"), "skin": 0.8},
        name="ball",
    )
    return world


@pytest.fixture
def tool(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """Runs `openfab print`; returns its statistics."""

    def run(world: Path, *words: str) -> dict[str, Any]:
        stats = tmp_path / "stats.json"
        command = [TOOL, "print", world, "--stats", stats, "--progress", "none", *words]
        subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=600)
        found: dict[str, Any] = json.loads(stats.read_text())
        return found

    return run
