# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""3MF files written by lib3mf, the consortium's own library."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Sequence

import lib3mf
import numpy as np
import pytest
from conftest import BLUE, GREEN, RED, TOP, WHITE, YELLOW, box, close, like, quad_picture
from PIL import Image

WRAPPER = lib3mf.get_wrapper()
OPAQUE_RED, OPAQUE_BLUE = (255, 0, 0), (0, 0, 255)


def add_box(model: Any, side: float = 4, at: Sequence[float] = (0, 0, 0), name: str = "", hollow: Any = None) -> Any:
    corners, faces = box(side, at)
    if hollow is not None:
        inner, inner_faces = box(*hollow)
        faces = np.concatenate([faces, inner_faces[:, ::-1] + len(corners)])
        corners = np.concatenate([corners, inner])
    mesh = model.AddMeshObject()
    mesh.SetName(name)
    mesh.SetGeometry(
        [lib3mf.Position((lib3mf.Lib3MF.ctypes.c_float * 3)(*c)) for c in corners],
        [lib3mf.Triangle((lib3mf.Lib3MF.ctypes.c_uint32 * 3)(*map(int, f))) for f in faces],
    )
    return mesh


def properties(resource: Any, ids: Sequence[int]) -> Any:
    out = lib3mf.TriangleProperties()
    out.ResourceID = resource.GetResourceID()
    for i in range(3):
        out.PropertyIDs[i] = ids[i]
    return out


def paint(mesh: Any, resource: Any, of_corner: Any) -> None:
    """Gives each triangle's corners properties; the object's own is that of the first corner."""
    for t in range(mesh.GetTriangleCount()):
        corners = mesh.GetTriangle(t).Indices
        mesh.SetTriangleProperties(t, properties(resource, [of_corner(t, corner) for corner in corners]))
    mesh.SetObjectLevelProperty(resource.GetResourceID(), of_corner(0, 0))


def place(model: Any, thing: Any, matrix: Any = None) -> None:
    model.AddBuildItem(thing, transform(matrix))


def transform(matrix: Any) -> Any:
    """Makes a transform from 4 x 3 numbers: rows for x, y and z, then the shift."""
    out = WRAPPER.GetIdentityTransform()
    if matrix is not None:
        for row in range(4):
            for column in range(3):
                out.Fields[row][column] = matrix[row][column]
    return out


def write(model: Any, path: Path) -> Path:
    model.QueryWriter("3mf").WriteToFile(str(path))
    return path


def rgba(color: Sequence[int], alpha: int = 255) -> Any:
    return WRAPPER.RGBAToColor(*color, alpha)


def two_materials(model: Any) -> tuple[Any, int, int]:
    group = model.AddBaseMaterialGroup()
    return group, group.AddMaterial("PLA", rgba(OPAQUE_RED)), group.AddMaterial("PLA", rgba(OPAQUE_BLUE))


def texture(model: Any, pixels: np.ndarray, tile: Any = None, kind: str = "png") -> Any:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, kind, **({"quality": 100, "subsampling": 0} if kind == "jpeg" else {}))
    attachment = model.AddAttachment(
        f"/3D/Textures/picture.{kind}", "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"
    )
    attachment.ReadFromBuffer(stream.getvalue())
    out = model.AddTexture2DFromAttachment(attachment)
    out.SetContentType(lib3mf.TextureType.JPEG if kind == "jpeg" else lib3mf.TextureType.PNG)
    if tile is not None:
        out.SetTileStyleUV(tile, tile)
    return out


def textured_box(model: Any, picture: Any, repeats: int = 1) -> tuple[Any, Any]:
    """Returns a box, 4 mm wide for each repetition of its picture along x and y."""
    mesh = add_box(model, 4 * repeats)
    group = model.AddTexture2DGroup(picture)
    ids = [group.AddTex2Coord(coordinates(x * repeats, y * repeats)) for y in (0, 1) for x in (0, 1)]
    paint(mesh, group, lambda _, corner: ids[corner & 3])
    return mesh, group


def coordinates(u: float, v: float) -> Any:
    out = lib3mf.Tex2Coord()
    out.U, out.V = u, v
    return out


def test_two_touching_bodies_have_two_materials_of_one_name(tmp_path, imported):
    model = WRAPPER.CreateModel()
    group, red, blue = two_materials(model)
    for x, material in ((0, red), (4, blue)):
        mesh = add_box(model, at=(x, 0, 0))
        mesh.SetObjectLevelProperty(group.GetResourceID(), material)
        place(model, mesh)
    made = imported(write(model, tmp_path / "two.3mf"))
    assert made.keys() == {OPAQUE_RED: 512, OPAQUE_BLUE: 512}
    left = made.codes[:, :, :8]
    assert (left == left[0, 0, 0]).all(), "no voxel has the other body's material"


@pytest.mark.parametrize("kind", ["outer first", "inner first", "cavity"])
def test_a_body_within_a_body_wins(tmp_path, imported, kind):
    model = WRAPPER.CreateModel()
    group, red, blue = two_materials(model)
    outer = add_box(model, 8, name="block", hollow=(4, (2, 2, 2)) if kind == "cavity" else None)
    inner = add_box(model, 4, (2, 2, 2), name="core")
    outer.SetObjectLevelProperty(group.GetResourceID(), red)
    inner.SetObjectLevelProperty(group.GetResourceID(), blue)
    for mesh in (inner, outer) if kind == "inner first" else (outer, inner):
        place(model, mesh)
    made = imported(write(model, tmp_path / "nested.3mf"))
    assert made.keys() == {OPAQUE_RED: 4096 - 512, OPAQUE_BLUE: 512}
    assert (made.codes[4:12, 4:12, 4:12] == made.codes[8, 8, 8]).all()


def test_base_materials_of_faces(tmp_path, imported):
    model = WRAPPER.CreateModel()
    group, red, blue = two_materials(model)
    mesh = add_box(model)
    paint(mesh, group, lambda t, _: blue if t in TOP else red)
    place(model, mesh)
    made = imported(write(model, tmp_path / "faces.3mf"))
    assert made.look(2, 2, 3.75) == OPAQUE_BLUE
    assert made.look(2, 2, 0.25) == OPAQUE_RED
    assert made.look(0.25, 2, 2) == OPAQUE_RED


def test_color_group_of_objects_and_of_corners(tmp_path, imported):
    model = WRAPPER.CreateModel()
    group = model.AddColorGroup()
    red, blue = group.AddColor(rgba(RED)), group.AddColor(rgba(BLUE))
    plain, shaded = add_box(model), add_box(model, at=(6, 0, 0))
    plain.SetObjectLevelProperty(group.GetResourceID(), red)
    paint(shaded, group, lambda _, corner: blue if corner & 1 else red)
    place(model, plain)
    place(model, shaded)
    made = imported(write(model, tmp_path / "colors.3mf"))
    assert like(made.look(2, 2, 3.75), RED)
    # The colour of a corner is that of both of the sides that it is on.
    assert like(made.look(6.25, 2, 2), RED, 4)
    assert like(made.look(9.75, 2, 2), BLUE, 4)


@pytest.mark.parametrize("kind", ["png", "jpeg"])
def test_texture(tmp_path, imported, kind):
    model = WRAPPER.CreateModel()
    mesh, _ = textured_box(model, texture(model, quad_picture(), kind=kind))
    place(model, mesh)
    made = imported(write(model, tmp_path / "texture.3mf"))
    within = 4 if kind == "jpeg" else 2
    assert like(made.look(0.75, 3.25, 3.75), RED, within), "top left"
    assert like(made.look(3.25, 3.25, 3.75), GREEN, within)
    assert like(made.look(0.75, 0.75, 3.75), BLUE, within), "below: v points up"
    assert like(made.look(3.25, 0.75, 3.75), YELLOW, within)


# The colours along the lowest row of a picture that is there twice along x.
@pytest.mark.parametrize(
    "tile, row",
    [
        ("Wrap", [BLUE, YELLOW, BLUE, YELLOW]),
        ("Mirror", [BLUE, YELLOW, YELLOW, BLUE]),
        ("Clamp", [BLUE, YELLOW, YELLOW, YELLOW]),
        ("NoTileStyle", [BLUE, YELLOW, WHITE, WHITE]),
    ],
)
def test_texture_tiles(tmp_path, imported, tile, row):
    model = WRAPPER.CreateModel()
    mesh, _ = textured_box(model, texture(model, quad_picture(), getattr(lib3mf.TextureTileStyle, tile)), 2)
    place(model, mesh)
    made = imported(write(model, tmp_path / "tiles.3mf"))
    seen = [made.look(x + 0.75, 0.75, 7.75) for x in range(0, 8, 2)]
    assert all(like(a, b) for a, b in zip(seen, row)), seen


def test_default_color_beyond_a_texture(tmp_path, imported):
    model = WRAPPER.CreateModel()
    mesh, _ = textured_box(model, texture(model, quad_picture(), lib3mf.TextureTileStyle.NoTileStyle), 2)
    colors = model.AddColorGroup()
    mesh.SetObjectLevelProperty(colors.GetResourceID(), colors.AddColor(rgba(GREEN)))
    place(model, mesh)
    made = imported(write(model, tmp_path / "default.3mf"))
    seen = [made.look(x + 0.75, 0.75, 7.75) for x in range(0, 8, 2)]
    assert all(like(a, b) for a, b in zip(seen, [BLUE, YELLOW, GREEN, GREEN])), seen


def test_composites_are_mixtures(tmp_path, imported):
    model = WRAPPER.CreateModel()
    group, red, blue = two_materials(model)
    composites = model.AddCompositeMaterials(group)
    parts = []
    for material, share in ((red, 0.3), (blue, 0.7)):
        part = lib3mf.CompositeConstituent()
        part.PropertyID, part.MixingRatio = material, share
        parts.append(part)
    mixed = composites.AddComposite(parts)
    mesh = add_box(model)
    mesh.SetObjectLevelProperty(composites.GetResourceID(), mixed)
    place(model, mesh)
    made = imported(write(model, tmp_path / "composite.3mf"))
    by_key = {made.key(name): f for name, f in made.mix(2, 2, 2).items()}
    assert close(by_key, {OPAQUE_RED: 0.3, OPAQUE_BLUE: 0.7})
    share = made.keys()[OPAQUE_RED] / 512
    assert abs(share - 0.3) < 0.03, "and the dither keeps them"


def test_multiproperties_lie_over_each_other(tmp_path, imported):
    model = WRAPPER.CreateModel()
    materials, red, _ = two_materials(model)
    pixels = np.zeros((8, 8, 4), dtype=np.uint8)
    pixels[:, :4] = (*GREEN, 255)
    picture = texture(model, pixels)
    textures = model.AddTexture2DGroup(picture)
    ids = [textures.AddTex2Coord(coordinates(x, y)) for y in (0, 1) for x in (0, 1)]
    multi = model.AddMultiPropertyGroup()
    for resource in (materials, textures):
        layer = lib3mf.MultiPropertyLayer()
        layer.ResourceID = resource.GetResourceID()
        layer.TheBlendMethod = lib3mf.BlendMethod.NoBlendMethod  # which lib3mf 2.5 writes as `mix`
        multi.AddLayer(layer)
    both = [multi.AddMultiProperty([red, uv]) for uv in ids]
    mesh = add_box(model)
    paint(mesh, multi, lambda _, corner: both[corner & 3])
    place(model, mesh)
    made = imported(write(model, tmp_path / "multi.3mf"))
    assert like(made.look(0.75, 2, 3.75), GREEN)
    assert made.mix(3.25, 2, 3.75) == {"PLA": 1.0}, "where the picture is transparent the material is seen"
    assert made.key("PLA") == OPAQUE_RED


def test_components_are_placed(tmp_path, imported):
    # A box at x 0 ... 4 turned about z by 90 degrees, moved; then once more as the item says.
    model = WRAPPER.CreateModel()
    group, red, blue = two_materials(model)
    meshes = [add_box(model, 4, at) for at in ((0, 0, 0), (4, 0, 0))]
    for mesh, material in zip(meshes, (red, blue)):
        mesh.SetObjectLevelProperty(group.GetResourceID(), material)
    turned = model.AddComponentsObject()
    for mesh in meshes:
        turned.AddComponent(mesh, transform([(0, 1, 0), (-1, 0, 0), (0, 0, 1), (4, 0, 0)]))
    place(model, turned)
    place(model, turned, [(1, 0, 0), (0, 1, 0), (0, 0, 0.5), (6, 0, 0)])
    made = imported(write(model, tmp_path / "components.3mf"))
    assert made.keys() == {OPAQUE_RED: 512 + 256, OPAQUE_BLUE: 512 + 256}
    assert made.codes.shape == (8, 16, 20)
    for x in (2, 8):
        assert made.look(x, 2, 1) == OPAQUE_RED
        assert made.look(x, 6, 1) == OPAQUE_BLUE
    assert made.look(8, 2, 3) is None, "half as high"


@pytest.mark.parametrize(
    "unit, mm", [("MicroMeter", 0.001), ("MilliMeter", 1), ("CentiMeter", 10), ("Inch", 25.4), ("Foot", 304.8), ("Meter", 1000)]
)
def test_units(tmp_path, imported, unit, mm):
    model = WRAPPER.CreateModel()
    model.SetUnit(getattr(lib3mf.ModelUnit, unit))
    place(model, add_box(model, 4 / mm))
    made = imported(write(model, tmp_path / "unit.3mf"))
    assert sum(made.counts().values()) == 512


def test_what_is_no_part_is_told(tmp_path, imported):
    model = WRAPPER.CreateModel()
    place(model, add_box(model))
    support = add_box(model, at=(8, 0, 0), name="stand")
    support.SetType(lib3mf.ObjectType.Support)
    place(model, support)
    made = imported(write(model, tmp_path / "support.3mf"))
    assert sum(made.counts().values()) == 512
    assert "left out" in made.told and "stand" in made.told
