# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Every kind of geometry in every form of a build, as tests/crossings has them: from Python as from the command line."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

import openfab
from conftest import ROOT

WRITER = ROOT / "build" / "release" / "tests" / "crossings_test"


@pytest.fixture(scope="module")
def worlds(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("worlds")
    subprocess.run(
        [WRITER, "--gtest_filter=CrossingsWorlds.*"], env=os.environ | {"OPENFAB_WORLDS_TO": str(folder)},
        check=True, capture_output=True,
    )
    return sorted(folder.iterdir())


def opened(folder: Path) -> tuple[openfab.FileWorld, dict[str, Any]]:
    """The world of a folder, and the uniforms that the options of its row set."""
    words = (folder / "OPTIONS").read_text().split()
    settings = dict(word.split("=") for word in words if "=" in word)
    world = openfab.load(folder / "w.fab.json", allow_programs="--allow-programs" in words)
    return world, {name: float(value) for name, value in settings.items()}


def test_every_kind_prints_as_from_the_command_line(worlds: list[Path], tool: Callable[..., dict[str, Any]]) -> None:
    assert len(worlds) >= 60
    for folder in worlds:
        tool(folder / "w.fab.json", *(folder / "OPTIONS").read_text().split(), "-o", str(folder / "tool.npy"))
        world, uniforms = opened(folder)
        codes = openfab.print_world(world, uniforms=uniforms).array()
        np.testing.assert_array_equal(codes, np.load(folder / "tool.npy"), folder.name)
        assert np.count_nonzero(codes) > 1000, folder.name
