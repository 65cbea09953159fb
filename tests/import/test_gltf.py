# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""glTF and GLB files written by pygltflib and trimesh."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib as gltf
import pytest
import trimesh
from conftest import BLUE, GREEN, RED, TOP, WHITE, YELLOW, box, like, linear, quad_picture, srgb
from PIL import Image
from PIL.PngImagePlugin import PngInfo

OPAQUE_RED, OPAQUE_BLUE = (255, 0, 0), (0, 0, 255)
REPEAT, CLAMP, MIRROR = 10497, 33071, 33648


def factor(color: Any, alpha: float = 1) -> list[float]:
    return [*(linear(c) for c in color), alpha]


class File:
    """A glTF file in the making; lengths are metres, up is y."""

    def __init__(self) -> None:
        self.gltf = gltf.GLTF2(scene=0, scenes=[gltf.Scene()], asset=gltf.Asset(version="2.0"))
        self.bytes = b""

    def accessor(self, values: np.ndarray, kind: str, normalized: bool = False) -> int:
        types = {"float32": gltf.FLOAT, "uint8": gltf.UNSIGNED_BYTE, "uint16": gltf.UNSIGNED_SHORT, "uint32": gltf.UNSIGNED_INT}
        self.gltf.accessors.append(
            gltf.Accessor(
                bufferView=self.view(values.tobytes()),
                componentType=types[str(values.dtype)],
                normalized=normalized,
                count=len(values),
                type=kind,
                min=values.min(axis=0).tolist() if values.ndim > 1 else None,
                max=values.max(axis=0).tolist() if values.ndim > 1 else None,
            )
        )
        return len(self.gltf.accessors) - 1

    def view(self, data: bytes) -> int:
        self.gltf.bufferViews.append(gltf.BufferView(buffer=0, byteOffset=len(self.bytes), byteLength=len(data)))
        self.bytes += data + b"\0" * (-len(data) % 4)
        return len(self.gltf.bufferViews) - 1

    def picture(self, pixels: np.ndarray, wrap: tuple[int, int] = (REPEAT, REPEAT), **more: Any) -> int:
        """Adds a texture and returns its number."""
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, "png", **more)
        self.gltf.images.append(gltf.Image(bufferView=self.view(stream.getvalue()), mimeType="image/png"))
        self.gltf.samplers.append(gltf.Sampler(wrapS=wrap[0], wrapT=wrap[1]))
        self.gltf.textures.append(gltf.Texture(source=len(self.gltf.images) - 1, sampler=len(self.gltf.samplers) - 1))
        return len(self.gltf.textures) - 1

    def material(self, name: str = "", color: Any = None, texture: Any = None, **more: Any) -> int:
        info = None if texture is None else gltf.TextureInfo(**texture)
        self.gltf.materials.append(
            gltf.Material(
                name=name,
                pbrMetallicRoughness=gltf.PbrMetallicRoughness(baseColorFactor=color, baseColorTexture=info),
                **more,
            )
        )
        return len(self.gltf.materials) - 1

    def box(self, material: int | None = None, repeats: int = 1, colors: np.ndarray | None = None) -> int:
        """Adds a box, 4 mm wide for each repetition of its picture along x and y of the print; returns the mesh's number."""
        side = 4 * repeats
        corners, faces = box(side)
        # x, y, z as printed is x, -z, y of the file.
        place = np.stack([corners[:, 0], corners[:, 2], -corners[:, 1]], axis=1).astype(np.float32) / 1000
        attributes = gltf.Attributes(POSITION=self.accessor(place, "VEC3"))
        # v of glTF points down.
        uv = np.stack([corners[:, 0] / side * repeats, repeats - corners[:, 1] / side * repeats], axis=1)
        attributes.TEXCOORD_0 = self.accessor(uv.astype(np.float32), "VEC2")
        if colors is not None:
            kind = "VEC3" if colors.shape[1] == 3 else "VEC4"
            attributes.COLOR_0 = self.accessor(colors, kind, normalized=colors.dtype != np.float32)
        indices = self.accessor(faces.astype(np.uint32).reshape(-1), "SCALAR")
        self.gltf.meshes.append(gltf.Mesh(primitives=[gltf.Primitive(attributes=attributes, indices=indices, material=material)]))
        return len(self.gltf.meshes) - 1

    def node(self, mesh: int | None = None, root: bool = True, **more: Any) -> int:
        self.gltf.nodes.append(gltf.Node(mesh=mesh, **more))
        if root:
            self.gltf.scenes[0].nodes.append(len(self.gltf.nodes) - 1)
        return len(self.gltf.nodes) - 1

    def write(self, path: Path) -> Path:
        self.gltf.buffers = [gltf.Buffer(byteLength=len(self.bytes))]
        self.gltf.set_binary_blob(self.bytes)
        if path.suffix == ".gltf":
            self.gltf.convert_buffers(gltf.BufferFormat.DATAURI)
        self.gltf.save(str(path))
        return path


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_two_materials_of_one_name(tmp_path, imported, kind):
    file = File()
    for x, color in ((0, OPAQUE_RED), (0.004, OPAQUE_BLUE)):
        file.node(file.box(file.material("PLA", factor(color))), translation=[x, 0, 0])
    made = imported(file.write(tmp_path / f"two.{kind}"))
    # A colour alone is a skin, or a material: either is seen.
    assert made.codes.shape == (8, 8, 16)
    red, blue = made.look(0.25, 2, 2), made.look(7.75, 2, 2)
    assert red != blue and red[0] > red[2] and blue[2] > blue[0]
    assert like(made.look(3.75, 2, 2), red) and like(made.look(4.25, 2, 2), blue), "each side of where they touch"


def test_color_factor(tmp_path, imported):
    file = File()
    file.node(file.box(file.material("a", factor(RED))))
    made = imported(file.write(tmp_path / "factor.glb"))
    assert like(made.look(2, 2, 3.75), RED), "linear light in the file, sRGB as it is seen"


def test_texture(tmp_path, imported):
    file = File()
    file.node(file.box(file.material("a", texture={"index": file.picture(quad_picture())})))
    made = imported(file.write(tmp_path / "texture.glb"))
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen


def test_what_a_texture_says_of_its_colors_is_ignored(tmp_path, imported):
    """glTF 2.0, on images: colour profiles and intents of a picture must be ignored, its colours are sRGB."""
    linear_light = PngInfo()
    linear_light.add(b"gAMA", (100000).to_bytes(4, "big"))
    file = File()
    file.node(file.box(file.material("a", texture={"index": file.picture(quad_picture(), pnginfo=linear_light)})))
    made = imported(file.write(tmp_path / "texture.glb"))
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen


def test_texture_is_multiplied_by_factor(tmp_path, imported):
    file = File()
    tint = [1, 0.5, 0.5, 1]
    file.node(file.box(file.material("a", tint, {"index": file.picture(np.full((4, 4, 3), GREEN, dtype=np.uint8))})))
    made = imported(file.write(tmp_path / "tinted.glb"))
    assert like(made.look(2, 2, 3.75), product(GREEN, tint))


def product(color: Any, factors: Any) -> list[float]:
    return [srgb(linear(c) * f) for c, f in zip(color, factors)]


def test_texture_transform(tmp_path, imported):
    # The quarter at the right and below: all YELLOW.
    file = File()
    info = {
        "index": file.picture(quad_picture(), (CLAMP, CLAMP)),
        "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.5], "scale": [0.5, 0.5]}},
    }
    file.gltf.extensionsUsed = ["KHR_texture_transform"]
    file.node(file.box(file.material("a", texture=info)))
    made = imported(file.write(tmp_path / "transform.glb"))
    seen = [made.look(x, y, 3.75) for x in (0.75, 3.25) for y in (0.75, 3.25)]
    assert all(like(a, YELLOW) for a in seen), seen


@pytest.mark.parametrize(
    "wrap, row, column",
    [
        ((REPEAT, REPEAT), [BLUE, YELLOW, BLUE, YELLOW], [BLUE, RED, BLUE, RED]),
        ((MIRROR, REPEAT), [BLUE, YELLOW, YELLOW, BLUE], [BLUE, RED, BLUE, RED]),
        ((CLAMP, MIRROR), [RED, GREEN, GREEN, GREEN], [RED, BLUE, BLUE, RED]),
    ],
)
def test_texture_wraps(tmp_path, imported, wrap, row, column):
    # v of the file is 0 at the top of the print and 2 at its bottom.
    file = File()
    file.node(file.box(file.material("a", texture={"index": file.picture(quad_picture(), wrap)}), repeats=2))
    made = imported(file.write(tmp_path / "wraps.glb"))
    along_x = [made.look(x + 0.75, 0.75, 7.75) for x in range(0, 8, 2)]
    along_y = [made.look(0.75, y + 0.75, 7.75) for y in range(0, 8, 2)]
    assert all(like(a, b) for a, b in zip(along_x, row)), along_x
    assert all(like(a, b) for a, b in zip(along_y, column)), along_y


# Elements begin at multiples of four bytes, so that three integers need a stride, which is not made here.
@pytest.mark.parametrize("kind, components", [("float32", 3), ("float32", 4), ("uint8", 4), ("uint16", 4)])
def test_vertex_colors(tmp_path, imported, kind, components):
    most = {"float32": 1, "uint8": 255, "uint16": 65535}[kind]
    at_left, at_right = ([linear(c) for c in color] + [1.0] for color in (RED, BLUE))
    values = np.array([at_right if i & 1 else at_left for i in range(8)])[:, :components]
    colors = values.astype(np.float32) if kind == "float32" else (values * most).round().astype(kind)
    file = File()
    file.node(file.box(file.material("a"), colors=colors))
    made = imported(file.write(tmp_path / "colors.glb"))
    assert like(made.look(0.25, 2, 2), RED, 4)
    assert like(made.look(3.75, 2, 2), BLUE, 4)


def test_vertex_colors_are_multiplied(tmp_path, imported):
    tint = [0.9, 1, 0.95, 1]
    pale = (230, 200, 200)
    colors = np.tile(np.array([linear(c) for c in pale] + [1], dtype=np.float32), (8, 1))
    file = File()
    picture = file.picture(np.full((4, 4, 3), GREEN, dtype=np.uint8))
    file.node(file.box(file.material("a", tint), colors=colors))
    file.node(file.box(file.material("b", tint, {"index": picture}), colors=colors), translation=[0.006, 0, 0])
    made = imported(file.write(tmp_path / "times.glb"))
    assert like(made.look(2, 2, 3.75), product(pale, tint))
    assert like(made.look(8, 2, 3.75), product(GREEN, [linear(c) * t for c, t in zip(pale, tint)]))


@pytest.mark.parametrize("mode", ["OPAQUE", "BLEND", "MASK"])
def test_alpha_modes(tmp_path, imported, mode):
    # Alpha of the left half is 0.4, of the right one 0.
    pixels = np.zeros((8, 8, 4), dtype=np.uint8)
    pixels[:] = (*GREEN, 0)
    pixels[:, :4, 3] = 102
    file = File()
    more = {"alphaMode": mode, **({"alphaCutoff": 0.3} if mode == "MASK" else {})}
    file.node(file.box(file.material("a", texture={"index": file.picture(pixels)}, **more)))
    made = imported(file.write(tmp_path / "alpha.glb"))
    left, right = made.mix(0.75, 2, 3.75), made.mix(3.25, 2, 3.75)
    if mode == "BLEND":
        full = imported_skin(GREEN)
        assert all(abs(left.get(ink, 0) - 0.4 * full[ink]) < 0.004 for ink in full), left
        assert right == {"white": 1.0}
    else:
        assert like(made.look(0.75, 2, 3.75), GREEN)
        assert like(made.look(3.25, 2, 3.75), GREEN if mode == "OPAQUE" else WHITE)


def imported_skin(color: Any) -> dict[str, float]:
    """Returns the inks of a skin after Beer and Lambert; 0.8 of the grey is black."""
    d = [-np.log10(linear(c)) / 1.2 for c in color]
    grey = 0.8 * min(d)
    return {"cyan": d[0] - grey, "magenta": d[1] - grey, "yellow": d[2] - grey, "black": grey}


def test_nodes_place_instances(tmp_path, imported):
    # One mesh three times: as it is, moved and turned by its parents, and half as large.
    file = File()
    mesh = file.box(file.material("a", factor(RED)))
    file.node(mesh)
    child = file.node(mesh, root=False, translation=[0.002, 0, 0])
    file.node(children=[child], translation=[0.006, 0, 0])
    matrix = np.diag([1, 0.5, 1, 1])
    matrix[:3, 3] = (0.016, 0, 0)
    file.node(mesh, matrix=matrix.T.reshape(-1).tolist())
    made = imported(file.write(tmp_path / "instances.glb"))
    assert sum(made.counts().values()) == 512 + 512 + 256
    assert made.codes.shape == (8, 8, 40)
    assert (made.codes[0, 0] != 0).nonzero()[0].tolist() == [*range(8), *range(16, 24), *range(32, 40)]


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_scene_of_trimesh(tmp_path, imported, kind):
    scene = trimesh.Scene()
    for x, color in ((0, RED), (0.006, BLUE)):
        mesh = trimesh.creation.box(extents=(0.004, 0.004, 0.004))
        mesh.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(name="m", baseColorFactor=[*color, 255])
        )
        mesh.apply_translation((x, 0, 0))
        scene.add_geometry(mesh)
    if kind == "glb":
        path = tmp_path / "scene.glb"
        scene.export(path)
    else:
        for name, data in scene.export(file_type="gltf").items():
            (tmp_path / name).write_bytes(data)
        path = tmp_path / "model.gltf"
    made = imported(path)
    assert made.codes.shape == (8, 8, 20)
    # trimesh's bytes are the factor's, without a curve.
    assert like(made.look(2, 2, 3.75), product(WHITE, [c / 255 for c in RED]))
    assert like(made.look(8, 2, 3.75), product(WHITE, [c / 255 for c in BLUE]))


def test_faces_of_one_node_with_two_materials(tmp_path, imported):
    # Two primitives that close one body: its top is RED, the rest BLUE.
    file = File()
    mesh = file.gltf.meshes[file.box(file.material("rest", factor(BLUE)))]
    primitive = mesh.primitives[0]
    _, faces = box()
    rest = np.array([t for i, t in enumerate(faces) if i not in TOP], dtype=np.uint32).reshape(-1)
    top = np.array([faces[i] for i in TOP], dtype=np.uint32).reshape(-1)
    primitive.indices = file.accessor(rest, "SCALAR")
    mesh.primitives.append(
        gltf.Primitive(
            attributes=primitive.attributes, indices=file.accessor(top, "SCALAR"), material=file.material("top", factor(RED))
        )
    )
    file.node(0)
    made = imported(file.write(tmp_path / "primitives.glb"))
    assert sum(made.counts().values()) == 512
    assert like(made.look(2, 2, 3.75), RED)
    assert like(made.look(2, 2, 0.25), BLUE)


def test_second_coordinates(tmp_path, imported):
    # TEXCOORD_0 is one point; the picture lies by TEXCOORD_1, which the transform names too.
    file = File()
    info = {"index": file.picture(quad_picture()), "texCoord": 1}
    moved = {
        "index": file.picture(quad_picture(), (CLAMP, CLAMP)),
        "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.5], "scale": [0.5, 0.5], "texCoord": 1}},
    }
    file.gltf.extensionsUsed = ["KHR_texture_transform"]
    for x, texture in ((0, info), (0.006, moved)):
        mesh = file.gltf.meshes[file.box(file.material("a", texture=texture))]
        attributes = mesh.primitives[0].attributes
        attributes.TEXCOORD_1 = attributes.TEXCOORD_0
        attributes.TEXCOORD_0 = file.accessor(np.full((8, 2), 0.25, dtype=np.float32), "VEC2")
        file.node(len(file.gltf.meshes) - 1, translation=[x, 0, 0])
    made = imported(file.write(tmp_path / "second.glb"))
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen
    seen = [made.look(x, y, 3.75) for x in (6.75, 9.25) for y in (0.75, 3.25)]
    assert all(like(a, YELLOW) for a in seen), seen


def test_strips_and_fans(tmp_path, imported):
    # The sides of a box as a strip, its top and bottom as fans; all share the corners.
    file = File()
    mesh = file.gltf.meshes[file.box(file.material("a", factor(RED)))]
    side = mesh.primitives[0]
    parts = {
        gltf.TRIANGLE_STRIP: [4, 0, 5, 1, 7, 3, 6, 2, 4, 0],
        gltf.TRIANGLE_FAN: [4, 5, 7, 6],
    }
    mesh.primitives = [
        gltf.Primitive(
            attributes=side.attributes,
            indices=file.accessor(np.array(corners, dtype=np.uint32), "SCALAR"),
            mode=mode,
            material=0,
        )
        for mode, corners in [*parts.items(), (gltf.TRIANGLE_FAN, [0, 2, 3, 1])]
    ]
    file.node(0)
    made = imported(file.write(tmp_path / "strips.glb"))
    assert sum(made.counts().values()) == 512
    assert like(made.look(2, 2, 3.75), RED)
