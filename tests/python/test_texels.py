# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Arrays of pictures and volumes: the files that the process caches have the bytes of the converter's."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BY_VOLUME, TOOL

import openfab
from openfab import _core

# All values of each kind, with some rest for the levels.
KINDS = {
    "u1": np.arange(259) % 256,
    "u2": np.arange(65541) % 65536,
    "f4": np.concatenate([np.linspace(-2, 3, 1001), [1e-30, -1e30, 1 / 3]]),
}


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Sets up an empty cache, and a process that cannot start the converter."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("OPENFAB_CACHE", str(folder))
    return folder


def written(texture: openfab.Texture, cache: Path) -> tuple[Path, bytes]:
    """Returns the file of a texture and its cached pyramid."""
    assert texture._file is not None
    path = texture._file.path()
    (kept,) = cache.glob("*.oftx")
    return path, kept.read_bytes()


def converted(path: Path, folder: Path, *words: str) -> bytes:
    out = folder / "converted.oftx"
    subprocess.run([TOOL, "texture", path, "-o", out, *words], check=True, capture_output=True)
    return out.read_bytes()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("channels", "space", "luminance"),
    [(1, "auto", False), *((3, space, False) for space in ("auto", "srgb", "linear", "data")), (3, "auto", True)],
)
def test_a_picture_is_kept_as_the_converter_makes_it(
    cache: Path, tmp_path: Path, kind: str, channels: int, space: str, luminance: bool
) -> None:
    values = KINDS[kind].astype(kind)
    count = 7 * (len(values) // 7)
    grey = values[:count].reshape(7, -1)
    array = grey[:, :, None] if channels == 1 else np.stack([grey, grey[::-1], grey[:, ::-1]], axis=-1)
    texture = openfab.Texture(array, space=space, channels="luminance" if luminance else "all")
    path, kept = written(texture, cache)
    assert kept == converted(path, tmp_path, "--space", space, *(["--luminance"] if luminance else []))


@pytest.mark.parametrize(("kind", "channels"), [("u1", 0), ("u2", 3), ("f4", 4), ("f4", 0)])
def test_a_volume_is_kept_as_the_converter_makes_it(cache: Path, tmp_path: Path, kind: str, channels: int) -> None:
    values = KINDS[kind].astype(kind)
    values = values[: 60 * (len(values) // 60)].reshape(3, -1, 5, 4 if channels == 4 else 1)
    array = values[..., 0] if channels == 0 else np.repeat(values, channels, 3)[..., :channels]
    texture = openfab.Texture.volume(np.asfortranarray(array), origin_mm=(-1, 0.1, 2), spacing_mm=(0.3, 1 / 3, 2))
    path, kept = written(texture, cache)
    words = ["--volume", "--origin=-1,0.1,2", f"--spacing=0.3,{1 / 3!r},2"]
    assert kept == converted(path, tmp_path, *words)


def test_small_arrays_start_no_program(cache: Path) -> None:
    _core.set_converter(Path("/nowhere/openfab-texture"))
    try:
        rows = np.linspace(0, 1, 4, dtype=np.float32)
        values = np.broadcast_to(rows, (4, 4, 4))
        assert np.allclose(printed(values).fractions[..., 0], values)
    finally:
        _core.set_converter(Path(_core.__file__).parent / "bin" / "openfab-texture")


def printed(values: Any, **keys: Any) -> openfab.Samples:
    """Returns the mixtures of a box filled by a volume, voxel by voxel."""
    world = openfab.World(printer="generic")
    one, other = openfab.Material("one", "#ffffff"), openfab.Material("other", "#000000")
    volume = openfab.Texture.volume(values, origin_mm=(-2, -2, 0), spacing_mm=1, **keys)
    world.add(openfab.box(4, 4, 4), openfab.Fablet(text=BY_VOLUME), {"field": volume, "one": one, "other": other})
    return openfab.sample(world, ((-2, -2, 0), (2, 2, 4)), voxel=1, sampling="centre")


def test_what_is_no_number_in_a_volume_is_what_is_outside() -> None:
    values = np.full((4, 4, 4), 0.25)
    values[1, 2, 3] = np.nan
    with pytest.raises(openfab.InputError, match=r"a volume has nan at \[1, 2, 3\].*`outside`"):
        openfab.Texture.volume(values)
    found = printed(values, outside=0.75).fractions[..., 0]
    assert np.allclose((found[1, 2, 3], found[0, 0, 0]), (0.75, 0.25), atol=1e-4) and np.isnan(values[1, 2, 3])
    values[0, 0, 0] = np.inf
    with pytest.raises(openfab.InputError, match=r"a volume has inf at \[0, 0, 0\]"):
        openfab.Texture.volume(values, outside=0)
    with pytest.raises(openfab.InputError, match="`outside` cannot be nan"):
        openfab.Texture.volume(values, outside=float("nan"))
    with pytest.raises(openfab.InputError, match=r"a picture has nan at \[0, 0\]"):
        openfab.Texture([[float("nan")]])
