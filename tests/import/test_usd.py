# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""USD files written by USD's own library: places, instances, colours, materials and pictures arrive, in millimetres."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from conftest import BLUE, GREEN, RED, TOOL, VOXEL, WHITE, YELLOW, box, like, linear, quad_picture, srgb
from PIL import Image

pxr = pytest.importorskip("pxr")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils, Vt  # noqa: E402

TYPES = Sdf.ValueTypeNames
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TOP_FACE = 1


@pytest.fixture(autouse=True)
def this_python(monkeypatch):
    """The program runs the `python3` on the PATH."""
    monkeypatch.setenv("PATH", os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"])


def stage(path: Path, metres: float = 0.001, up: str = "Z") -> Usd.Stage:
    out = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(out, metres)
    UsdGeom.SetStageUpAxis(out, up)
    return out


def cube(of: Usd.Stage, path: str, side: float = 4) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(of, path)
    mesh.CreatePointsAttr([tuple(p) for p in box(side)[0]])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([i for q in QUADS for i in q])
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def move(prim, at) -> None:
    UsdGeom.Xformable(prim).AddTranslateOp().Set(tuple(map(float, at)))


def light(srgb) -> tuple[float, ...]:
    return tuple(linear(c) for c in srgb)


def material(of: Usd.Stage, path: str, color=None) -> tuple[UsdShade.Material, UsdShade.Shader]:
    made, shader = UsdShade.Material.Define(of, path), UsdShade.Shader.Define(of, path + "/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    made.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    if color:
        shader.CreateInput("diffuseColor", TYPES.Color3f).Set(light(color))
    return made, shader


def bind(prim, made: UsdShade.Material) -> None:
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(made)


def textured(path: Path) -> None:
    """A cube with the picture of four squares on its top, by a second set of coordinates, half of it on each side."""
    of = stage(path)
    Image.fromarray(quad_picture()).save(path.parent / "four squares.png")
    mesh = cube(of, "/part")
    api = UsdGeom.PrimvarsAPI(mesh)
    api.CreatePrimvar("st", TYPES.TexCoord2fArray, "vertex").Set([(0.1, 0.1)] * 8)
    api.CreatePrimvar("st1", TYPES.TexCoord2fArray, "vertex").Set([(float(p[0]) / 2, float(p[1])) for p in box(4)[0]])
    made, shader = material(of, "/looks/photo")
    picture, reader, turn = (UsdShade.Shader.Define(of, f"/looks/photo/{n}") for n in ("picture", "reader", "turn"))
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", TYPES.Asset).Set("./four squares.png")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", TYPES.String).Set("st1")
    turn.CreateIdAttr("UsdTransform2d")
    turn.CreateInput("in", TYPES.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    turn.CreateInput("scale", TYPES.Float2).Set((0.5, 0.25))
    picture.CreateInput("st", TYPES.Float2).ConnectToSource(turn.ConnectableAPI(), "result")
    shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(picture.ConnectableAPI(), "rgb")
    bind(mesh, made)
    of.Save()


@pytest.mark.parametrize("kind", ["usda", "usdc", "usdz"])
def test_pictures(tmp_path, imported, kind):
    written = tmp_path / f"photo.{'usda' if kind == 'usdz' else kind}"
    textured(written)
    if kind == "usdz":
        assert UsdUtils.CreateNewUsdzPackage(str(written), str(tmp_path / "photo.usdz"))
        written.unlink()
        (tmp_path / "four squares.png").unlink()
    made = imported(tmp_path / f"photo.{kind}")
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen


def test_the_alpha_of_a_picture_counts_only_where_it_is_connected(tmp_path, imported):
    written = tmp_path / "photo.usda"
    textured(written)
    quads = Image.open(tmp_path / "four squares.png").convert("RGB")
    quads.putalpha(64)
    quads.save(tmp_path / "four squares.png")
    made = imported(written)
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen


@pytest.mark.parametrize("opacity", [0.5, 1])
def test_a_threshold_of_opacity_is_a_mask(tmp_path, imported, opacity):
    of = stage(tmp_path / "mask.usda")
    made, shader = material(of, "/looks/blue", BLUE)
    shader.CreateInput("opacity", TYPES.Float).Set(opacity)
    shader.CreateInput("opacityThreshold", TYPES.Float).Set(0.1)
    bind(cube(of, "/part"), made)
    of.Save()
    assert like(imported(tmp_path / "mask.usda").look(2, 2, 3.75), BLUE)


@pytest.mark.parametrize("metres, up", [(0.01, "Y"), (1, "Z"), (0.0254, "Y")])
def test_units_and_axes(tmp_path, imported, metres, up):
    of = stage(tmp_path / "unit.usda", metres, up)
    scale = 0.001 / metres
    mesh = cube(of, "/part", 1)
    UsdGeom.Xformable(mesh).AddScaleOp().Set((2 * scale, 4 * scale, 6 * scale))
    mesh.CreateDisplayColorPrimvar("constant").Set([light(BLUE)])
    of.Save()
    shape = imported(tmp_path / "unit.usda").codes.shape  # z, y, x
    assert [n * VOXEL for n in shape] == ([4, 6, 2] if up == "Y" else [6, 4, 2])


def test_places_and_instances(tmp_path, imported):
    """Instances of a class, of a list of points, mirrored and turned; what is hidden or stands in is none."""
    of = stage(tmp_path / "many.usda")
    made = material(of, "/looks/blue", BLUE)[0]
    bind(cube(of, "/_kind/part", 2), made)
    of.GetPrimAtPath("/_kind").SetSpecifier(Sdf.SpecifierClass)
    for i in range(2):
        own = UsdGeom.Xform.Define(of, f"/copy{i}")
        own.GetPrim().GetInherits().AddInherit("/_kind")
        own.GetPrim().SetInstanceable(True)
        move(own, (6 * i, 0, 0))
    many = UsdGeom.PointInstancer.Define(of, "/many")
    move(many, (0, 6, 0))
    kind = cube(of, "/many/kinds/part", 2)
    bind(kind, material(of, "/looks/red", RED)[0])
    move(kind, (0, 0, 1))
    many.CreatePrototypesRel().SetTargets(["/many/kinds/part"])
    many.CreateProtoIndicesAttr([0, 0])
    many.CreatePositionsAttr([(0, 0, 0), (8, 0, 0)])
    half = float(np.sqrt(0.5))
    many.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0), Gf.Quath(half, 0, 0, half)])  # a quarter turn about z
    mirrored = cube(of, "/mirrored", 2)
    bind(mirrored, made)
    move(mirrored, (14, 0, 0))
    UsdGeom.Xformable(mirrored).AddScaleOp().Set((-1, 1, 1))
    UsdGeom.Imageable(cube(of, "/hidden", 9)).MakeInvisible()
    cube(of, "/proxy", 9).CreatePurposeAttr("proxy")
    of.Save()
    made = imported(tmp_path / "many.usda")
    assert made.keys() == {BLUE: 3 * 64, RED: 2 * 64}
    for point, color in [((1, 1, 1), BLUE), ((7, 1, 1), BLUE), ((13, 1, 1), BLUE), ((1, 7, 2), RED), ((7, 7, 2), RED)]:
        assert like(made.look(*point), color), point
    assert made.look(1, 7, 0.5) is None and made.look(9, 7, 2) is None
    assert "invisible" in made.told and "/hidden" in made.told


@pytest.mark.parametrize("where", ["below", "class", "over", "own colour", "every"])
def test_colors_of_instances(tmp_path, imported, where):
    """The primvars of an instancer hold for each of its instances, as those of points for points; the prototype's own come first."""
    of = stage(tmp_path / "dots.usda")
    many = UsdGeom.PointInstancer.Define(of, "/many")
    outside = {"class": Sdf.SpecifierClass, "over": Sdf.SpecifierOver}.get(where)
    kind = "/kinds/part" if outside else "/many/part"
    mesh = cube(of, kind, 2)
    if outside:
        of.GetPrimAtPath("/kinds").SetSpecifier(outside)
    if where == "own colour":
        mesh.CreateDisplayColorPrimvar("constant").Set([light(YELLOW)])
    many.CreatePrototypesRel().SetTargets([kind])
    many.CreateProtoIndicesAttr([0, 0, 0])
    many.CreatePositionsAttr([(0, 0, 0), (4, 0, 0), (8, 0, 0)])
    many.CreateInvisibleIdsAttr([1])
    colors = UsdGeom.PrimvarsAPI(many).CreatePrimvar("displayColor", TYPES.Color3fArray, "constant" if where == "every" else "vertex")
    colors.Set([light(GREEN)] if where == "every" else [light(c) for c in (RED, GREEN, BLUE)])
    of.Save()
    made = imported(tmp_path / "dots.usda")
    expected = {"own colour": (YELLOW, YELLOW), "every": (GREEN, GREEN)}.get(where, (RED, BLUE))
    seen = [made.look(1, 1, 1.75), made.look(9, 1, 1.75)]
    assert all(like(*pair) for pair in zip(seen, expected)), seen
    assert made.look(5, 1, 1) is None


@pytest.mark.parametrize("purposes, color", [("preview full", GREEN), ("full", RED), ("all full", BLUE), ("all preview full", GREEN)])
def test_materials_of_purposes(tmp_path, imported, purposes, color):
    """The material for previews, which has the UsdPreviewSurface, before that of all purposes and that of finished pictures."""
    of = stage(tmp_path / "two.usda")
    mesh = cube(of, "/part")
    api = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    for purpose, own in (("all", BLUE), ("preview", GREEN), ("full", RED)):
        if purpose in purposes.split():
            api.Bind(material(of, f"/looks/{purpose}", own)[0], materialPurpose="" if purpose == "all" else purpose)
    of.Save()
    made = imported(tmp_path / "two.usda")
    assert like(made.look(2, 2, 3.75), color)
    assert ("/looks/full" in made.told) == (purposes != "full")


@pytest.mark.parametrize("purpose", ["guide", "proxy", "render", "default"])
def test_what_stands_in_is_told(tmp_path, imported, purpose):
    of = stage(tmp_path / "two.usda")
    cube(of, "/part", 2)
    other = cube(of, "/other", 2)
    other.CreatePurposeAttr(purpose)
    move(other, (4, 0, 0))
    of.Save()
    made = imported(tmp_path / "two.usda")
    is_printed = purpose in ("render", "default")
    assert sum(made.counts().values()) == 64 * (1 + is_printed)
    assert (f"`{purpose}`" in made.told and "/other" in made.told) != is_printed


def deep_tiff(path: Path, value: int) -> None:
    """A TIFF of 16 bits a channel, one colour."""
    side = 4
    entries = [(256, 3, 1, side), (257, 3, 1, side), (258, 3, 3, 200), (259, 3, 1, 1), (262, 3, 1, 2), (273, 4, 1, 256)]
    entries += [(277, 3, 1, 3), (278, 3, 1, side), (279, 4, 1, side * side * 6)]
    head = struct.pack("<2sHIH", b"II", 42, 8, len(entries))
    head += b"".join(struct.pack("<HHII", *entry) for entry in entries) + struct.pack("<I", 0)
    head = head.ljust(200, b"\0") + struct.pack("<HHH", 16, 16, 16)
    path.write_bytes(head.ljust(256, b"\0") + np.full((side, side, 3), value, "<u2").tobytes())


def deep_png(path: Path, value: int, kind: int) -> None:
    """A PNG of 16 bits a channel (kind 2, colours) or of 8 (kind 0, grey)."""
    side, row = 4, value.to_bytes(2, "big") * 3 * 4 if kind == 2 else bytes([value]) * 4

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", side, side, 16 if kind == 2 else 8, kind, 0, 0, 0)
    rows = zlib.compress((b"\0" + row) * side)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))


def half_exr(path: Path, value: float) -> None:
    """An OpenEXR picture of halves, one colour, without compression."""
    side = 4

    def attribute(name: str, kind: str, data: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(data)) + data

    channels = b"".join(c + b"\0" + struct.pack("<IB3xII", 1, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, side - 1, side - 1)
    head = struct.pack("<II", 20000630, 2) + attribute("channels", "chlist", channels)
    head += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", window)
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", bytes(8))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row = np.full(3 * side, value, "<f2").tobytes()
    first = len(head) + 8 * side
    table = b"".join(struct.pack("<Q", first + y * (8 + len(row))) for y in range(side))
    path.write_bytes(head + table + b"".join(struct.pack("<iI", y, len(row)) + row for y in range(side)))


PICTURES = {
    "colours.png": lambda path: Image.new("RGB", (4, 4), (188, 188, 188)).save(path),
    "deep.png": lambda path: deep_png(path, 188 * 257, 2),
    "grey.png": lambda path: deep_png(path, 188, 0),
    "deep.tif": lambda path: deep_tiff(path, 188 * 257),
    "half.exr": lambda path: half_exr(path, 188 / 255),
}


@pytest.mark.parametrize("space", ["sRGB", "raw", "auto", None])
@pytest.mark.parametrize("name", sorted(PICTURES))
def test_spaces_of_pictures(tmp_path, imported, name, space):
    """`sRGB` and `raw` hold for each kind; by `auto` pictures of 8 bits and three channels are sRGB, and others as they are."""
    of = stage(tmp_path / "part.usda")
    PICTURES[name](tmp_path / name)
    mesh = cube(of, "/part")
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", TYPES.TexCoord2fArray, "vertex").Set([(0.5, 0.5)] * 8)
    made, shader = material(of, "/looks/photo")
    picture = UsdShade.Shader.Define(of, "/looks/photo/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", TYPES.Asset).Set(f"./{name}")
    if space:
        picture.CreateInput("sourceColorSpace", TYPES.Token).Set(space)
    shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(picture.ConnectableAPI(), "rgb")
    bind(mesh, made)
    of.Save()
    is_srgb = space == "sRGB" or (space != "raw" and name == "colours.png")
    grey = 188 if is_srgb else srgb(188 / 255)
    seen = imported(tmp_path / "part.usda").look(2, 2, 3.75)
    assert like(seen, [grey] * 3), (seen, grey)


def test_materials_of_subsets(tmp_path, imported):
    of = stage(tmp_path / "two.usda")
    mesh = cube(of, "/part")
    bind(mesh, material(of, "/looks/blue", BLUE)[0])
    subset = UsdShade.MaterialBindingAPI(mesh.GetPrim()).CreateMaterialBindSubset("top", Vt.IntArray([TOP_FACE]))
    bind(subset, material(of, "/looks/red", RED)[0])
    move(cube(of, "/bare", 2), (6, 0, 0))
    of.Save()
    made = imported(tmp_path / "two.usda")
    assert like(made.look(2, 2, 3.75), RED) and like(made.look(2, 2, 0.25), BLUE)
    assert made.look(7, 1, 1) not in (None, RED, BLUE) and "left out" not in made.told


@pytest.mark.parametrize("kind", ["uniform", "faceVarying"])
def test_colors_of_faces(tmp_path, imported, kind):
    of = stage(tmp_path / "faces.usda")
    mesh = cube(of, "/part")
    colors = [light(RED if face == TOP_FACE else BLUE) for face in range(6)]
    mesh.CreateDisplayColorPrimvar(kind).Set(colors if kind == "uniform" else [c for c in colors for _ in range(4)])
    of.Save()
    made = imported(tmp_path / "faces.usda")
    assert like(made.look(2, 2, 3.75), RED) and like(made.look(2, 2, 0.25), BLUE)


def test_left_handed_faces_with_an_index_of_colors(tmp_path, imported):
    of = stage(tmp_path / "left.usda")
    mesh = cube(of, "/part")
    mesh.CreateOrientationAttr("leftHanded")
    mesh.GetFaceVertexIndicesAttr().Set([i for q in QUADS for i in q[::-1]])
    colors = mesh.CreateDisplayColorPrimvar("vertex")
    colors.Set([light(WHITE), light(GREEN)])
    colors.SetIndices(Vt.IntArray([1] * 8))
    of.Save()
    made = imported(tmp_path / "left.usda")
    assert like(made.look(2, 2, 3.75), GREEN) and like(made.look(2, 2, 0.25), GREEN)


def told(*arguments) -> tuple[int, str]:
    done = subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stderr


def test_what_is_not_read_is_told(tmp_path):
    of = stage(tmp_path / "round.usda")
    mesh = cube(of, "/part")
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    UsdGeom.Sphere.Define(of, "/ball")
    made, shader = material(of, "/looks/outside")
    picture = UsdShade.Shader.Define(of, "/looks/outside/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", TYPES.Asset).Set("../secret.png")
    shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(picture.ConnectableAPI(), "rgb")
    bind(mesh, made)
    of.Save()
    (tmp_path / "inner").mkdir()
    (tmp_path / "round.usda").rename(tmp_path / "inner" / "round.usda")
    Image.fromarray(quad_picture()).save(tmp_path / "secret.png")
    code, notes = told("import", tmp_path / "inner" / "round.usda", "-o", tmp_path / "world")
    assert code == 0, notes
    assert "catmullClark" in notes and "`Sphere`" in notes and "outside of the file's folder" in notes
    assert not list((tmp_path / "world").glob("*.png"))


@pytest.mark.parametrize(
    "text, reason",
    [
        ('#usda 1.0\ndef Mesh "a" {\n', "Failed to open layer"),
        ('#usda 1.0\ndef Xform "a" {\n}\n', "no mesh with faces"),
        (
            '#usda 1.0\ndef Mesh "a" {\nint[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 9]\n'
            "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n}\n",
            "a face names a vertex that is not there",
        ),
    ],
)
def test_damaged_files_are_refused(tmp_path, text, reason):
    (tmp_path / "a.usda").write_text(text)
    code, notes = told("import", tmp_path / "a.usda", "-o", tmp_path / "world")
    assert code == 1 and reason in notes and "a.usda" in notes and "/opt/" not in notes, notes
