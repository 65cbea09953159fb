# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong is told by the call that it is given to, and what is asked for is found there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import openfab
import pytest
from openfab import InputError

WHITE, BLACK = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")
BALL = """fablet Ball {
    @uniform { Material core, shell; float skin = 0.5; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float t = saturate(-distance(attr.voxelCenter) / skin);
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}"""
TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def test_a_printer_that_is_not_known_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="`printer` cannot be 'j75'; did you mean `j750`"):
        openfab.World(printer="j75")
    with pytest.raises(InputError, match="there is no such file"):
        openfab.World(printer=tmp_path / "own.printer.json")
    with pytest.raises(InputError, match="it is the name of a printer"):
        openfab.World(printer=750)  # type: ignore[arg-type]
    world = openfab.World(printer="j750")
    world.add(openfab.sphere(2), openfab.Fablet(text=BALL), {"core": WHITE, "shell": BLACK})
    with pytest.raises(InputError, match="did you mean `j750`"):
        openfab.estimate(world, printer="j75")
    own = tmp_path / "own.printer.json"
    own.write_text(json.dumps({"name": "own", "pitch_mm": [0.5, 0.5, 0.5]}))
    assert openfab.World(printer=own).to_json()["printer"] == str(own)


def test_a_uniform_that_nothing_binds_is_told_of_its_object() -> None:
    world = openfab.World(printer="generic")
    ball = world.add(openfab.sphere(2), openfab.Fablet(text=BALL), {"core": WHITE})
    for call in (openfab.estimate, openfab.preview):
        with pytest.raises(InputError, match="object `ball` does not bind `shell`, a `Material` of `Ball`; it binds `core`") as told:
            call(world)
        assert "world.add" in str(told.value) or "world.add" in (told.value.help or "")
        assert ".fab.json" not in str(told.value)
    # A placement, a print or the object may bind it.
    openfab.estimate(world, uniforms={"ball.shell": BLACK})
    ball["shell"] = BLACK
    openfab.estimate(world)
    world = openfab.World(printer="generic")
    world.add(openfab.sphere(2), openfab.Fablet(text=BALL), {"core": WHITE}, place=False).place(uniforms={"shell": BLACK})
    openfab.estimate(world)
    # An object that nothing places lacks what it likes.
    world.add(openfab.sphere(2), openfab.Fablet(text=BALL), name="spare", place=False)
    openfab.estimate(world)


def size_of(world: openfab.World) -> np.ndarray:
    voxels = openfab.print_world(world, voxel=0.5).array()
    filled = np.argwhere(voxels > 0)
    return (filled.max(axis=0) - filled.min(axis=0) + 1)[::-1] * 0.5


def test_a_mesh_gets_a_size(tmp_path: Path) -> None:
    file = tmp_path / "corner.obj"
    file.write_text(TETRAHEDRON.format(3))
    vertices = [(0, 0, 0), (3, 0, 0), (0, 3, 0), (0, 0, 3)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    given = {"core": WHITE, "shell": BLACK}
    for mesh in (file, openfab.FileMesh(file, unit="cm"), openfab.Mesh(vertices, faces)):
        world = openfab.World(printer="generic")
        world.add(mesh, openfab.Fablet(text=BALL), given, size_mm=20)
        np.testing.assert_allclose(size_of(world), 20, atol=1.5)
    part = openfab.World(printer="generic").add(file, openfab.Fablet(text=BALL), given, place=False)
    with pytest.raises(InputError, match="give one of them"):
        part.place(size_mm=20, scale=2)
    with pytest.raises(InputError, match="`size_mm` cannot be 0"):
        part.place(size_mm=0)
    with pytest.raises(InputError, match="`size_mm` is of meshes"):
        openfab.World(printer="generic").add(openfab.sphere(2), openfab.Fablet(text=BALL), given, size_mm=20)
    with pytest.raises(InputError, match="none.obj"):
        openfab.World(printer="generic").add(tmp_path / "none.obj", openfab.Fablet(text=BALL), given, size_mm=20)


def test_mixtures_at_scattered_points_are_those_of_a_box() -> None:
    world = openfab.World(printer="generic")
    for x in (0, 400):  # far apart, so that the box of both is large
        part = world.add(openfab.sphere(4), openfab.Fablet(text=BALL), {"core": WHITE, "shell": BLACK}, translate=(x, 0))
        assert part.name
    box = openfab.sample(world, ((-5, -5, -1), (5, 5, 9)), voxel=0.25)
    random = np.random.default_rng(5)
    points = random.uniform((-5, -5, -1), (5, 5, 9), (2000, 3))
    points[:100] = np.round(points[:100] * 4) / 4  # in the faces of voxels
    inside = np.all((points >= (-5, -5, -1)) & (points < (5, 5, 9)), axis=1)
    points = points[inside]
    found = openfab.sample_at(world, points, voxel=0.25)
    np.testing.assert_array_equal(found.fractions, box.at(points))
    assert [one.name for one in found.materials] == ["white", "black"]
    np.testing.assert_allclose(found.mean({"white": 1, "black": 0}), box.at(points)[:, 0], atol=1e-6)
    # Of both balls at once, in any shape; nothing far away.
    both = np.stack([points[:60].reshape(6, 10, 3), points[:60].reshape(6, 10, 3) + (400, 0, 0)])
    of_both = openfab.sample_at(world, both, voxel=0.25).fractions
    assert of_both.shape == (2, 6, 10, 2)
    np.testing.assert_array_equal(of_both[0], of_both[1])
    np.testing.assert_array_equal(of_both[0].reshape(60, 2), box.at(points[:60]))
    nothing = openfab.sample_at(world, [(600, 0, 0), (0, 0, 2)], voxel="0.25mm").fractions
    np.testing.assert_array_equal(nothing[0], 0)
    assert nothing[1].sum() == pytest.approx(1)
    for wrong in ((1, 2), np.zeros((0, 3)), [(np.nan, 0, 0)]):
        with pytest.raises(InputError, match="`points` ha"):
            openfab.sample_at(world, wrong, voxel=0.25)


def test_places_without_material_are_told() -> None:
    half = """fablet Half {
    @uniform { Material core; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(core, attr.voxelCenter.x); return mc; }
}"""
    world = openfab.World(printer="generic")
    world.add(openfab.box(4, 4, 4), openfab.Fablet(text=half), {"core": WHITE})
    (note,) = openfab.estimate(world).notes
    assert "50 % of `half`" in note


def test_the_module_needs_no_archive_of_the_system() -> None:
    """Archives of a distribution need not be position independent: libexpat.a of Debian 13 is not."""
    from openfab import _core

    readelf = shutil.which("readelf")
    if readelf is None:
        pytest.skip("readelf is not there")
    needed = subprocess.run([readelf, "-d", _core.__file__], capture_output=True, text=True, check=True).stdout
    libraries = re.findall(r"\(NEEDED\).*\[lib([a-z_]+)", needed)
    for name in ("expat", "z", "zstd", "deflate"):
        assert name in libraries, needed
