# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of trimesh and pyvista, with their attributes."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import openfab
from openfab.shapes import as_mesh

BY_HEAT = """fablet ByHeat {
    @uniform { Material one, other; }
    @Volume(@varying { VolumeAttributes attr, @nearest float heat })
    {
        MaterialComposition mc;
        mc.Set(one, heat);
        mc.Set(other, 1 - heat);
        return mc;
    }
}
"""


def volume_of(mesh: Any) -> float:
    """Returns the printed volume of a mesh in cubic millimetres."""
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text="fablet F { @uniform { Material m; } @Volume(@varying { VolumeAttributes attr }) "
                                 "{ MaterialComposition mc; mc.Set(m, 1); return mc; } }")
    world.add(mesh, fablet, {"m": openfab.Material("m", "#ffffff")})
    return float(openfab.sample(world, voxel=0.5).fractions.sum()) / 8


def test_a_scene_is_all_of_its_meshes_where_they_stand() -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    box = trimesh.creation.box(extents=(2, 3, 4))
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix((0, 0, 2)))
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[:3, 3] = (10, 0, 2)
    scene.add_geometry(box, transform=mirrored)
    scene.add_geometry(trimesh.creation.icosphere(radius=2), transform=trimesh.transformations.translation_matrix((0, 9, 2)))
    made = as_mesh(scene)
    assert isinstance(made, openfab.Mesh)
    assert np.allclose(made.vertices.min(0), (-2, -1.5, 0)) and np.allclose(made.vertices.max(0), (11, 11, 4))
    assert set(made._columns[2]["part"].ravel()) == {0, 1, 2}
    # Of the ball the voxels whose centres are within its facets.
    assert abs(volume_of(scene) - (24 + 24 + 32)) <= 4
    with pytest.raises(openfab.InputError, match="the scene has no mesh"):
        as_mesh(trimesh.Scene())
    scene.add_geometry(trimesh.load_path([[(0, 0, 0), (1, 0, 0)]]), geom_name="line")
    with pytest.raises(openfab.InputError, match="`line` of the scene is no mesh"):
        as_mesh(scene)


def test_colours_of_a_scene() -> None:
    trimesh = pytest.importorskip("trimesh")
    red, plain = trimesh.creation.box(extents=(1, 1, 1)), trimesh.creation.box(extents=(1, 1, 1))
    red.visual.vertex_colors = (255, 0, 0, 255)
    plain.apply_translation((5, 0, 0))
    with pytest.warns(openfab.PrintWarning, match="part 1 of the scene has no colours of vertices"):
        made = as_mesh(trimesh.Scene([red, plain]))
    assert isinstance(made, openfab.Mesh)
    assert made._columns[0]["color"].tolist() == [[1, 0, 0]] * 8 + [[1, 1, 1]] * 8


def test_units_of_a_trimesh_count() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box(extents=(1, 1, 1))
    for unit, size in ((None, 1), ("mm", 1), ("inches", 25.4), ("meters", 1000)):
        box.units = unit
        made = as_mesh(box)
        assert isinstance(made, openfab.Mesh) and np.allclose(np.ptp(made.vertices, axis=0), size)
    box.units = "furlongs"
    with pytest.raises(openfab.InputError, match="the unit 'furlongs'"):
        as_mesh(box)


def test_a_mesh_of_pyvista_with_its_arrays() -> None:
    pyvista = pytest.importorskip("pyvista")
    box = pyvista.Box((-2, 2, -1, 1, 0, 3))  # of quads
    box.point_data["heat"] = np.clip((box.points[:, 2]) / 3, 0, 1)
    box.point_data["a b"] = np.zeros((8, 3), np.float32)
    box.cell_data["side"] = np.arange(6)
    box.point_data["nine"] = np.zeros((8, 9))
    with pytest.warns(openfab.PrintWarning, match="the array `nine` of points is left out"):
        made = as_mesh(box)
    assert isinstance(made, openfab.Mesh)
    vertex, _, face = made._columns
    assert len(made.faces) == 12 and set(vertex) == {"heat", "a_b"} and sorted(set(face["side"].ravel())) == list(range(6))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", openfab.PrintWarning)
        assert abs(volume_of(box) - 24) < 1e-6
        world = openfab.World(printer="generic")
        one, other = openfab.Material("one", "#ffffff"), openfab.Material("other", "#000000")
        world.add(box, openfab.Fablet(text=BY_HEAT), {"one": one, "other": other})
    found = openfab.sample(world, voxel=1).fractions[..., 0]
    assert found[0].mean() < found[2].mean()


def test_surfaces_of_other_data_of_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=(3, 4, 5), spacing=(1, 1, 1))
    assert abs(volume_of(grid) - 24) < 1e-6
    blocks = pyvista.MultiBlock([pyvista.Box((0, 2, 0, 2, 0, 2)), pyvista.Box((5, 6, 0, 2, 0, 2))])
    assert abs(volume_of(blocks) - 12) < 1e-6
    with pytest.raises(openfab.InputError, match="points or lines besides faces"):
        as_mesh(pyvista.Line())
    sphere = as_mesh(pyvista.Sphere(radius=3))
    assert isinstance(sphere, openfab.Mesh) and "n" in sphere._columns[0]
