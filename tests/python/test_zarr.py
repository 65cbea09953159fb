# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Stores of Zarr as other programs read them: zarr-python, tensorstore and ome-zarr see the voxels that were printed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import openfab

zarr = pytest.importorskip("zarr")

PITCH = 0.02  # the ball has 300 voxels a side, so two levels and chunks of each kind


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ball whose skin is dithered, printed in two parts into one store."""
    world = openfab.World(printer="generic", title="ball")
    fablet = openfab.Fablet(text="""fablet Ball {
    @uniform { Material core, shell; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0, 1, -distance(attr.voxelCenter));
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
""")
    materials = {"core": openfab.Material("white", "#ffffff"), "shell": openfab.Material("black", "#101010")}
    world.add(openfab.sphere(6), fablet, materials, name="ball")
    path = tmp_path_factory.mktemp("store") / "ball.zarr"
    for slices in ((152, 300), (0, 152)):
        openfab.print_world(world, path, voxel=PITCH, slices=slices)
    openfab.print_world(world, path.with_suffix(".npy"), voxel=PITCH)
    return path


@pytest.fixture(scope="module")
def codes(store: Path) -> Any:
    return np.load(store.with_suffix(".npy"))


def halved(codes: Any) -> Any:
    """The most frequent code of 2 x 2 x 2, the lowest of several, counted by numpy."""
    padded = np.pad(codes, [(0, side % 2) for side in codes.shape], mode="edge")
    z, y, x = (side // 2 for side in padded.shape)
    cells = padded.reshape(z, 2, y, 2, x, 2).transpose(0, 2, 4, 1, 3, 5).reshape(z, y, x, 8)
    counts = np.stack([(cells == code).sum(-1) for code in range(codes.max() + 1)])
    return counts.argmax(0)


def test_zarr_python(store: Path, codes: Any) -> None:
    group = zarr.open_group(store, mode="r")
    assert group["0"].dtype == np.uint8 and group["0"].chunks == (8, 128, 128)
    assert np.array_equal(group["0"][:], codes)
    assert np.array_equal(group["1"][:], halved(codes))
    assert "2" not in group
    ome = group.attrs["ome"]
    assert ome["version"] == "0.5"
    scale, translation = ome["multiscales"][0]["datasets"][1]["coordinateTransformations"]
    assert np.allclose(scale["scale"], 2 * PITCH)
    # The middle of the first voxel, which is twice as large.
    read = openfab.read(store)
    assert np.allclose(translation["translation"], np.array(read.info.origin_mm)[::-1] + PITCH)
    assert [label["name"] for label in ome["image-label"]["properties"]] == ["white", "black"]
    assert np.array_equal(np.asarray(read[:]), codes)


def test_tensorstore(store: Path, codes: Any) -> None:
    tensorstore = pytest.importorskip("tensorstore")
    opened = tensorstore.open({"driver": "zarr3", "kvstore": {"driver": "file", "path": f"{store}/0"}}).result()
    assert opened.domain.labels == ("z", "y", "x")
    assert np.array_equal(opened.read().result(), codes)


def test_ome_zarr(store: Path, codes: Any) -> None:
    reader = pytest.importorskip("ome_zarr.reader")
    io = pytest.importorskip("ome_zarr.io")
    (node,) = reader.Reader(io.parse_url(str(store)))()
    assert [level.shape for level in node.data] == [(300, 300, 300), (150, 150, 150)]
    assert np.array_equal(np.asarray(node.data[0]), codes)
    assert node.metadata["properties"][2]["name"] == "black"
    assert np.allclose(node.metadata["color"][2][:3], 0x10 / 255)
