# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Volumes written by pynrrd, nibabel, meshio and numpy: each voxel has the value that was passed to the writer."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import meshio
import nibabel
import nrrd
import numpy as np
import pytest
from conftest import TOOL, VOXEL, Print

FABLET = """fablet V {
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
SIZE = (4, 3, 2)  # mm, and texels of 1 mm


def world(folder: Path, texture: dict) -> Path:
    (folder / "v.fl").write_text(FABLET)
    x, y, z = SIZE
    path = folder / "v.fab.json"
    path.write_text(
        json.dumps(
            {
                "openfab": 1,
                "printer": "generic",
                "fablets": {"v": {"source": "v.fl", "fablet": "V"}},
                "materials": {"one": {"key": "#ff0000"}, "other": {"key": "#00ff00"}},
                "textures": {"t": {"wrap": "clamp", "filter": "nearest", **texture}},
                "meshes": {"m": {"extrusion": {"polygons": [[[0, 0], [x, 0], [x, y], [0, y]]], "height": z}}},
                "objects": {"o": {"mesh": "m", "fablet": "v", "uniforms": {"field": "t", "one": "one", "other": "other"}}},
                "build": [{"object": "o"}],
            }
        )
    )
    return path


def field() -> np.ndarray:
    """Returns a different number for each texel, by x, y and z."""
    x, y, z = np.meshgrid(*(np.arange(n) for n in SIZE), indexing="ij")
    return ((1 + x + 4 * y + 12 * z) / 32).astype(np.float32)


def printed(folder: Path, texture: dict) -> np.ndarray:
    """Returns the share of `one` in each voxel, by x, y and z."""
    made = Print(folder, world(folder, texture), "")
    return made.fractions[..., made.names.index("one")].transpose(2, 1, 0)


def assert_field(folder: Path, texture: dict, expected: np.ndarray | None = None, within: float = 1e-4) -> None:
    seen = printed(folder, texture)
    wanted = field() if expected is None else expected
    for axis in range(3):
        wanted = wanted.repeat(round(1 / VOXEL), axis)
    assert seen.shape == wanted.shape
    assert np.abs(seen - wanted).max() <= within


# Axes as they are stored: which of x, y, z each is, and whether it runs backwards.
@pytest.mark.parametrize("axes", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
@pytest.mark.parametrize("turned", [(), (0,), (1, 2)])
@pytest.mark.parametrize("encoding", ["raw", "gzip"])
def test_nrrd_axes(tmp_path, axes, turned, encoding):
    data = field().transpose(axes)
    directions, origin = np.zeros((3, 3)), np.full(3, 0.5)
    for stored, axis in enumerate(axes):
        directions[stored, axis] = 1
    for stored in turned:
        data = np.flip(data, stored)
        directions[stored] *= -1
        origin[axes[stored]] = SIZE[axes[stored]] - 0.5
    header = {
        "space": "left-posterior-superior",
        "space directions": directions,
        "space origin": origin,
        "encoding": encoding,
        "kinds": ["domain"] * 3,
    }
    nrrd.write(str(tmp_path / "v.nrrd"), np.ascontiguousarray(data), header, index_order="F")
    assert_field(tmp_path, {"file": "v.nrrd"})


@pytest.mark.parametrize("encoding", ["raw", "ascii"])
def test_detached_nrrd(tmp_path, encoding):
    header = {"spacings": [1, 1, 1], "encoding": encoding}
    nrrd.write(str(tmp_path / "v.nhdr"), field(), header, detached_header=True, index_order="F")
    assert_field(tmp_path, {"file": "v.nhdr", "origin_mm": [0, 0, 0], "spacing_mm": 1})


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_nrrd_of_integers(tmp_path, kind):
    most = np.iinfo(kind).max
    data = (field() * most).round().astype(kind)
    nrrd.write(str(tmp_path / "v.nrrd"), data, {"spacings": [1, 1, 1]}, index_order="F")
    assert_field(tmp_path, {"file": "v.nrrd", "origin_mm": [0, 0, 0]}, data.astype(np.float64) / most)


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8"])
def test_npy(tmp_path, kind, order):
    data = np.array(field().transpose(2, 1, 0).astype(kind), order=order)
    np.save(tmp_path / "v.npy", data)
    assert_field(tmp_path, {"file": "v.npy", "origin_mm": [0, 0, 0], "spacing_mm": 1}, data.transpose(2, 1, 0), 1e-4)


def hexahedra(of_points: bool = False) -> meshio.Mesh:
    """Returns a hexahedron for each texel, with the texel's value."""
    nx, ny, nz = SIZE
    points = np.array(
        [(x, y, z) for z in range(nz + 1) for y in range(ny + 1) for x in range(nx + 1)], dtype=np.float64
    )
    at = lambda x, y, z: x + (nx + 1) * (y + (ny + 1) * z)  # noqa: E731
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = [
        [at(x + i, y + j, z + k) for i, j, k in corners] for z in range(nz) for y in range(ny) for x in range(nx)
    ]
    if of_points:
        return meshio.Mesh(points, [("hexahedron", cells)], point_data={"s": linear_field(points)})
    values = field().transpose(2, 1, 0).reshape(-1).astype(np.float64)
    return meshio.Mesh(points, [("hexahedron", cells)], cell_data={"s": [values]})


def linear_field(points: np.ndarray) -> np.ndarray:
    """Returns a field that linear shape functions reproduce exactly."""
    return (points @ np.array([2, 3, 4]) + 1) / 32


WRITERS = {
    "text.vtk": {"file_format": "vtk", "binary": False},
    "bytes.vtk": {"file_format": "vtk", "binary": True},
    "v42.vtk": {"file_format": "vtk42", "binary": True},
    "text.vtu": {"file_format": "vtu", "binary": False},
    "zlib.vtu": {"file_format": "vtu", "binary": True, "compression": "zlib"},
    "plain.vtu": {"file_format": "vtu", "binary": True, "compression": None},
    "text.xdmf": {"file_format": "xdmf", "data_format": "XML"},
    "bytes.xdmf": {"file_format": "xdmf", "data_format": "Binary"},
}


@pytest.mark.parametrize("name", WRITERS)
def test_cells_of_meshio(tmp_path, name):
    meshio.write(tmp_path / name, hexahedra(), **WRITERS[name])
    assert_field(tmp_path, {"file": name, "field": "s", "pitch_mm": 0.5})


@pytest.mark.parametrize("name", WRITERS)
def test_points_of_meshio(tmp_path, name):
    meshio.write(tmp_path / name, hexahedra(of_points=True), **WRITERS[name])
    seen = printed(tmp_path, {"file": name, "field": "s", "pitch_mm": 0.5})
    at = np.stack(np.meshgrid(*((np.arange(2 * n) + 0.5) * VOXEL for n in SIZE), indexing="ij"), axis=-1)
    assert np.abs(seen - linear_field(at)).max() < 1e-3


def test_tetrahedra_of_meshio(tmp_path):
    mesh = hexahedra(of_points=True)
    split = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    cells = [[cell[i] for i in t] for cell in mesh.cells[0].data for t in split]
    meshio.write(tmp_path / "t.vtu", meshio.Mesh(mesh.points, [("tetra", cells)], point_data=mesh.point_data))
    seen = printed(tmp_path, {"file": "t.vtu", "field": "s", "pitch_mm": 0.5})
    at = np.stack(np.meshgrid(*((np.arange(2 * n) + 0.5) * VOXEL for n in SIZE), indexing="ij"), axis=-1)
    assert np.abs(seen - linear_field(at)).max() < 1e-3


@pytest.mark.parametrize("offset, fine", [(352, True), (0, False), (347, False)])
def test_numbers_of_nifti_lie_behind_its_header(tmp_path, offset, fine):
    affine = np.eye(4)
    affine[:3, 3] = 0.5
    file = tmp_path / "v.nii"
    nibabel.save(nibabel.Nifti1Image(field(), affine), file)
    raw = bytearray(file.read_bytes())
    raw[108:112] = np.array(offset, "<f4").tobytes()
    file.write_bytes(raw)
    if fine:
        return assert_field(tmp_path, {"file": "v.nii"})
    command = [TOOL, "print", world(tmp_path, {"file": "v.nii"}), "-o", tmp_path / "o.npy", "--voxel", "0.5mm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and "vox_offset" in done.stderr, done.stderr


def test_nifti_is_read_or_refused_by_name(tmp_path):
    affine = np.eye(4)
    affine[:3, 3] = 0.5
    nibabel.save(nibabel.Nifti1Image(field(), affine), tmp_path / "v.nii")
    done = subprocess.run(
        [TOOL, "print", world(tmp_path, {"file": "v.nii"}), "-o", tmp_path / "o.npy", "--voxel", "0.5mm"],
        capture_output=True,
        text=True,
    )
    if done.returncode == 0:
        assert_field(tmp_path, {"file": "v.nii"})
    else:
        assert done.returncode == 1 and "NIfTI" in done.stderr, done.stderr
