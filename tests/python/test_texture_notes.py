# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What converters tell of a texture's file is a warning of each print, also where the texture comes from the cache."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import BY_VOLUME

import openfab

NRRD = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\naxis mins: 5 6 7\n\n\x80\x80"


def test_notes_of_converters_are_warnings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENFAB_CACHE", str(tmp_path / "cache"))
    (tmp_path / "mins.nrrd").write_bytes(NRRD)
    world = openfab.World(printer="generic")
    one, other = openfab.Material("one", "#ffffff"), openfab.Material("other", "#000000")
    field = openfab.Texture.volume(tmp_path / "mins.nrrd", wrap="clamp")
    world.add(openfab.box(2, 2, 2), openfab.Fablet(text=BY_VOLUME), {"field": field, "one": one, "other": other})
    for _ in range(2):
        with pytest.warns(openfab.PrintWarning, match="mins.nrrd: its `axis mins` are left out"):
            openfab.sample(world, ((-1, -1, 0), (1, 1, 2)), voxel=0.5)
