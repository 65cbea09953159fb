# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""OBJ and PLY files written by trimesh and meshio; handwritten files for features that they lack, and for STL colours."""

from __future__ import annotations

import struct
from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh
from conftest import BLUE, GREEN, RED, TOP, WHITE, YELLOW, box, like, quad_picture
from PIL import Image

MM = ("--unit", "mm")


def mesh(at=(0, 0, 0), **more) -> trimesh.Trimesh:
    corners, faces = box(at=at)
    return trimesh.Trimesh(corners, faces, process=False, **more)


def colors(of) -> np.ndarray:
    return np.array([[*of(i), 255] for i in range(8)], dtype=np.uint8)


def textured() -> trimesh.Trimesh:
    out = mesh()
    uv = (out.vertices[:, :2] / 4).copy()
    material = trimesh.visual.material.SimpleMaterial(image=Image.fromarray(quad_picture()))
    out.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return out


def save(made: dict, text, path: Path) -> Path:
    """Writes the files that trimesh exports with a mesh."""
    for name, data in made.items():
        (path.parent / name).write_bytes(data)
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def assert_quad(made) -> None:
    seen = [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]
    assert all(like(a, b) for a, b in zip(seen, (RED, GREEN, BLUE, YELLOW))), seen


def test_obj_with_a_texture(tmp_path, imported):
    text, files = trimesh.exchange.obj.export_obj(textured(), return_texture=True)
    made = imported(save(files, text, tmp_path / "textured.obj"), *MM)
    assert_quad(made)


@pytest.mark.parametrize("kind", ["obj", "ply", "ply ascii"])
def test_vertex_colors(tmp_path, imported, kind):
    of = mesh(vertex_colors=colors(lambda i: BLUE if i & 1 else RED))
    path = tmp_path / f"colors.{kind[:3]}"
    path.write_bytes(
        of.export(file_type="obj", include_color=True).encode()
        if kind == "obj"
        else of.export(file_type="ply", encoding="ascii" if kind == "ply ascii" else "binary")
    )
    made = imported(path, *MM)
    assert like(made.look(0.25, 2, 2), RED, 4)
    assert like(made.look(3.75, 2, 2), BLUE, 4)


def test_ply_with_face_colors(tmp_path, imported):
    of = mesh(face_colors=np.array([[*(BLUE if t in TOP else RED), 255] for t in range(12)], dtype=np.uint8))
    path = tmp_path / "faces.ply"
    path.write_bytes(of.export(file_type="ply"))
    made = imported(path, *MM)
    assert like(made.look(2, 2, 3.75), BLUE)
    assert like(made.look(2, 2, 0.25), RED)


def test_ply_of_meshio(tmp_path, imported):
    corners, faces = box()
    path = tmp_path / "meshio.ply"
    channels = {name: np.full(8, c, dtype=np.uint8) for name, c in zip(("red", "green", "blue"), GREEN)}
    meshio.write(path, meshio.Mesh(corners, [("triangle", faces)], point_data=channels))
    assert like(imported(path, *MM).look(2, 2, 3.75), GREEN)


@pytest.mark.parametrize("names", ["s t", "u v", "texture_u texture_v"])
def test_ply_with_a_texture(tmp_path, imported, names):
    # trimesh writes no coordinates of textures; MeshLab, Blender and CloudCompare name them so.
    corners, faces = box()
    Image.fromarray(quad_picture()).save(tmp_path / "quad.png")
    u, v = names.split()
    lines = ["ply", "format ascii 1.0", "comment TextureFile quad.png", "element vertex 8"]
    lines += [f"property float {n}" for n in ("x", "y", "z", u, v)]
    lines += ["element face 12", "property list uchar int vertex_indices", "end_header"]
    lines += [f"{x} {y} {z} {x / 4} {y / 4}" for x, y, z in corners]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path = tmp_path / "textured.ply"
    path.write_text("\n".join(lines) + "\n")
    assert_quad(imported(path, *MM))


def test_obj_scene_has_two_bodies(tmp_path, imported):
    scene = trimesh.Scene()
    for x, color in ((0, (255, 0, 0)), (4, (0, 0, 255))):
        part = mesh((x, 0, 0))
        part.visual = trimesh.visual.TextureVisuals(
            uv=np.zeros((8, 2)), material=trimesh.visual.material.SimpleMaterial(name=f"m{x}", diffuse=[*color, 255])
        )
        scene.add_geometry(part, node_name=f"part {x}", geom_name=f"part {x}")
    text, files = trimesh.exchange.obj.export_obj(scene, return_texture=True)
    made = imported(save(files, text, tmp_path / "scene.obj"), *MM)
    left, right = made.look(0.25, 2, 2), made.look(7.75, 2, 2)
    assert left[0] > left[2] and right[2] > right[0]
    assert like(made.look(3.75, 2, 2), left) and like(made.look(4.25, 2, 2), right)
    assert made.codes.shape == (8, 8, 16)


def test_obj_groups_with_materials(tmp_path, imported):
    corners, faces = box()
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n")
    lines = ["mtllib m.mtl", *(f"v {x} {y} {z}" for x, y, z in corners), "g rest", "usemtl a"]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for t, (a, b, c) in enumerate(faces) if t not in TOP]
    lines += ["g top", "usemtl b", *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces[list(TOP)])]
    path = tmp_path / "groups.obj"
    path.write_text("\n".join(lines) + "\n")
    made = imported(path, *MM)
    assert made.look(2, 2, 3.75) == (0, 0, 255) and made.look(2, 2, 0.25) == (255, 0, 0)
    assert sum(made.counts().values()) == 512


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_of_trimesh(tmp_path, imported, kind):
    path = tmp_path / "box.stl"
    data = trimesh.util.concatenate([mesh(), mesh((6, 0, 0))]).export(file_type=kind)
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    made = imported(path, *MM)
    assert sum(made.counts().values()) == 1024 and made.codes.shape == (8, 8, 20)


@pytest.mark.parametrize("writer", ["VisCAM", "Magics"])
def test_colors_of_stl(tmp_path, imported, writer):
    # Five bits a channel: VisCAM has red in the high ones and its flag set where there is a colour; Magics the other
    # way round, beside a colour of the whole in its header.
    of = lambda t: BLUE if t in TOP else RED  # noqa: E731
    corners, faces = box()
    header = b"COLOR=" + bytes([*WHITE, 255]) if writer == "Magics" else b"made by VisCAM"
    data = header.ljust(80, b"\0") + struct.pack("<I", 12)
    for t, face in enumerate(faces):
        r, g, b = (round(c * 31 / 255) for c in of(t))
        bits = r << 10 | g << 5 | b | 0x8000 if writer == "VisCAM" else b << 10 | g << 5 | r
        data += struct.pack("<12fH", 0, 0, 0, *corners[face].reshape(-1), bits)
    path = tmp_path / "colored.stl"
    path.write_bytes(data)
    made = imported(path, *MM)
    five_bits = lambda color: [round(c * 31 / 255) * 255 / 31 for c in color]  # noqa: E731
    assert like(made.look(2, 2, 3.75), five_bits(BLUE))
    assert like(made.look(2, 2, 0.25), five_bits(RED))


def test_options_of_a_material_file(tmp_path, imported):
    # Half as large and moved by a quarter of the picture, clamped: columns are as the writers of OBJ mean it.
    text, files = trimesh.exchange.obj.export_obj(textured(), return_texture=True)
    library = next(name for name in files if name.endswith(".mtl"))
    picture = next(name for name in files if not name.endswith(".mtl"))
    lines = files[library].decode().replace(f"map_Kd {picture}", f"map_Kd -clamp on -s 2 2 1 {picture}")
    assert "-clamp" in lines
    made = imported(save({**files, library: lines.encode()}, text, tmp_path / "options.obj"), *MM)
    # u, v go from 0 to 2: the picture is in the quarter at the left and below, and its edge beyond.
    assert like(made.look(0.25, 0.25, 3.75), BLUE) and like(made.look(1.75, 0.25, 3.75), YELLOW)
    assert like(made.look(3.25, 0.25, 3.75), YELLOW) and like(made.look(3.25, 3.25, 3.75), GREEN)


def test_ply_with_coordinates_of_corners(tmp_path, imported):
    # As MeshLab writes them: a list of six numbers a face.
    corners, faces = box()
    Image.fromarray(quad_picture()).save(tmp_path / "quad.png")
    lines = ["ply", "format ascii 1.0", "comment TextureFile quad.png", "element vertex 8"]
    lines += [f"property float {n}" for n in "xyz"]
    lines += ["element face 12", "property list uchar int vertex_indices", "property list uchar float texcoord"]
    lines += ["end_header", *(f"{x} {y} {z}" for x, y, z in corners)]
    for face in faces:
        uv = " ".join(f"{x / 4} {y / 4}" for x, y, _ in corners[face])
        lines.append(f"3 {' '.join(map(str, face))} 6 {uv}")
    path = tmp_path / "wedges.ply"
    path.write_text("\n".join(lines) + "\n")
    assert_quad(imported(path, *MM))
