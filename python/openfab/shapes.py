# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes and textures: files, primitives and arrays."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _files
from .errors import InputError


class Mesh:
    """A closed triangle mesh, in millimetres, z up.

    `vertices` has shape (n, 3), `faces` (m, 3), counter-clockwise seen from outside. `normals` are (n, 3), `uv`
    (n, 2), or (m, 3, 2) for one at each corner. Further attributes are found by fablets under their names:
    those of vertices, of shape (n,) or (n, components), are floats; those of faces ints or floats. The arrays are
    copied.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        uv: ArrayLike | None = None,
        vertex_attributes: Mapping[str, ArrayLike] | None = None,
        face_attributes: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        self.vertices: NDArray[np.float64] = np.array(vertices, np.float64)
        self.faces: NDArray[np.int32] = np.array(faces, np.int32)
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise InputError(f"vertices have the shape {self.vertices.shape}; it should be (n, 3)")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise InputError(f"faces have the shape {self.faces.shape}; it should be (m, 3), of triangles")
        count = len(self.vertices)
        vertex = {name: _columns(name, values, count) for name, values in (vertex_attributes or {}).items()}
        if normals is not None:
            vertex["n"] = _columns("normals", normals, count, 3)
        corners: NDArray[np.float32] | None = None
        if uv is not None:
            coordinates = np.asarray(uv, np.float32)
            if coordinates.ndim == 3:
                corners = _columns("uv", coordinates.reshape(len(coordinates), -1), len(self.faces), 6)
            else:
                vertex["uv"] = _columns("uv", coordinates, count, 2)
        face = {name: _columns(name, values, len(self.faces)) for name, values in (face_attributes or {}).items()}
        self._file = _files.OwnedFile(self, "mesh", ".ply", lambda path: _write_ply(path, self, vertex, corners, face))

    @classmethod
    def from_trimesh(cls, mesh: Any) -> Mesh:
        """Takes over a trimesh.Trimesh with its texture coordinates and colours, which fablets see as `color`."""
        visual: Any = getattr(mesh, "visual", None)
        uv = getattr(visual, "uv", None)
        attributes = {}
        if getattr(visual, "kind", None) == "vertex":
            srgb = np.asarray(visual.vertex_colors, np.float64)[:, :3] / 255
            attributes["color"] = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        return cls(mesh.vertices, mesh.faces, uv=uv, vertex_attributes=attributes)

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        path = self._file.path()
        allow.add(path.parent)
        return {"file": str(path), "unit": "mm"}

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces)"


class FileMesh:
    """A mesh file (OBJ, STL, PLY, 3MF, glTF), and how to read it: see `meshes` of a world."""

    def __init__(
        self, file: str | os.PathLike[str], *, unit: str | None = None, up: str | None = None,
        groups: Mapping[str, int] | None = None,
    ) -> None:
        self.file = Path(file).absolute()
        self._keys = {"unit": unit, "up": up, "groups": None if groups is None else dict(groups)}

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        allow.add(self.file.parent)
        return {"file": str(self.file), **{key: value for key, value in self._keys.items() if value is not None}}

    def __repr__(self) -> str:
        return f"FileMesh({str(self.file)!r})"


class Primitive:
    """A shape that needs no file and stands on z = 0; see box, sphere, cylinder, plane, cone, torus, capsule, extrusion
    and revolution."""

    def __init__(self, kind: str, size: Any) -> None:
        self.kind = kind
        self.size = size

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        return {self.kind: self.size}

    def __repr__(self) -> str:
        return f"Primitive({self.kind!r}, {self.size!r})"


def box(width: float, depth: float, height: float) -> Primitive:
    """A box; its faces have the int attribute `face`: 0 +z, 1 -z, 2 -y, 3 +x, 4 +y, 5 -x."""
    return Primitive("box", [width, depth, height])


def sphere(diameter: float) -> Primitive:
    """A sphere."""
    return Primitive("sphere", diameter)


def cylinder(diameter: float, height: float) -> Primitive:
    """A cylinder; `face` is 0 on its top, 1 on its bottom and 2 around it."""
    return Primitive("cylinder", [diameter, height])


def plane(width: float, depth: float) -> Primitive:
    """A sheet closed by its own back, for displacement; `face` is 0 in front, 1 on the back."""
    return Primitive("plane", [width, depth])


def cone(low_diameter: float, high_diameter: float, height: float) -> Primitive:
    """A cone, cut off or, with a diameter of 0, pointed; `face` is 0 on its top, 1 on its bottom and 2 around it."""
    return Primitive("cone", [low_diameter, high_diameter, height])


def torus(diameter: float, section: float) -> Primitive:
    """A ring of round section; the diameters are those of its middle and of the section."""
    return Primitive("torus", [diameter, section])


def capsule(diameter: float, length: float) -> Primitive:
    """A cylinder along z with a half ball on each end; the length includes them."""
    return Primitive("capsule", [diameter, length])


def _corners(polygon: Any) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in polygon]


def extrusion(polygons: Sequence[Any], height: float) -> Primitive:
    """What an area sweeps from z = 0 up to a height. A polygon is a sequence, or an array of shape (n, 2), of its corners
    in mm; one that lies within another bounds a hole. `face` is 0 on the top, 1 on the bottom and 2 around."""
    return Primitive("extrusion", {"polygons": [_corners(polygon) for polygon in polygons], "height": float(height)})


def revolution(polygon: Any) -> Primitive:
    """What a polygon of (distance from the axis, z) sweeps around the z axis, in mm, with 128 facets around; `face` is 0
    where it faces straight up, 1 straight down and 2 elsewhere."""
    return Primitive("revolution", _corners(polygon))


AnyMesh = Mesh | FileMesh | Primitive


def as_mesh(value: Any) -> AnyMesh:
    """Returns what can stand for a mesh: a mesh, a file, or a trimesh.Trimesh."""
    if isinstance(value, (Mesh, FileMesh, Primitive)):
        return value
    if isinstance(value, (str, os.PathLike)):
        return FileMesh(value)
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return Mesh.from_trimesh(value)
    raise InputError(f"{value!r} is no mesh; pass a Mesh, a file, a primitive or a trimesh.Trimesh")


def _columns(name: str, values: ArrayLike, count: int, components: int = 0) -> NDArray[Any]:
    array = np.array(values)
    array = array.reshape(len(array), -1) if array.ndim else array
    if array.ndim != 2 or len(array) != count or (components and array.shape[1] != components):
        wanted = f"({count}, {components or 'components'})"
        raise InputError(f"`{name}` has the shape {np.shape(values)}; it should be {wanted}")
    if array.dtype.kind in "iu":
        return array.astype(np.int32)
    return array.astype(np.float32)


def _properties(name: str, array: NDArray[Any]) -> list[tuple[str, NDArray[Any]]]:
    """The columns of an attribute under the names that readers of PLY put together again."""
    known = {"n": ("nx", "ny", "nz"), "uv": ("u", "v")}
    count = array.shape[1]
    names = known.get(name, (name,) if count == 1 else tuple(f"{name}_{i}" for i in range(count)))
    return [(column, array[:, i]) for i, column in enumerate(names)]


_Field = tuple[str, NDArray[Any]]
_List = tuple[str, str, NDArray[Any]]


def _write_ply(
    path: Path, mesh: Mesh, vertex: dict[str, NDArray[Any]], corners: NDArray[np.float32] | None,
    face: dict[str, NDArray[Any]],
) -> None:
    words = {"f": "float", "d": "double", "i": "int"}
    header = ["ply", "format binary_little_endian 1.0"]

    def element(name: str, count: int, fields: list[_Field], lists: list[_List]) -> bytes:
        header.append(f"element {name} {count}")
        kinds: list[Any] = []
        for list_name, kind, values in lists:
            header.append(f"property list uchar {words[kind]} {list_name}")
            kinds += [(f"{list_name} length", "u1"), (list_name, f"<{np.dtype(kind).str[1:]}", (values.shape[1],))]
        for field_name, values in fields:
            header.append(f"property {words[values.dtype.char]} {field_name}")
            kinds.append((field_name, values.dtype.newbyteorder("<")))
        table = np.zeros(count, np.dtype(kinds))
        for list_name, _, values in lists:
            table[f"{list_name} length"] = values.shape[1]
            table[list_name] = values
        for field_name, values in fields:
            table[field_name] = values
        return table.tobytes()

    fields = [(axis, mesh.vertices[:, i]) for i, axis in enumerate("xyz")]
    for name, array in vertex.items():
        fields += _properties(name, array.astype(np.float32))
    body = element("vertex", len(mesh.vertices), fields, [])
    lists: list[_List] = [("vertex_indices", "i", mesh.faces)]
    if corners is not None:
        lists.append(("texcoord", "f", corners))
    fields = [column for name, array in face.items() for column in _properties(name, array)]
    body += element("face", len(mesh.faces), fields, lists)
    path.write_bytes("\n".join([*header, "end_header", ""]).encode() + body)


class Texture:
    """A picture or a volume for a fablet's texture.

    A picture is a file, or an array [row][column] or [row][column][channel], the top row first: of 8 or 16 bits, or
    of floats, which are taken as they are. `Texture.volume` takes arrays of volumes. An array is copied.
    """

    def __init__(
        self, picture: str | os.PathLike[str] | ArrayLike, *, wrap: str = "repeat", filter: str = "anisotropic",
        space: str = "auto", channels: str = "all",
    ) -> None:
        self._keys: dict[str, Any] = {"wrap": wrap, "filter": filter, "space": space, "channels": channels}
        self._file: _files.OwnedFile | None = None
        if isinstance(picture, (str, os.PathLike)):
            self.file = Path(picture).absolute()
            return
        array = np.array(picture)
        array = array[:, :, None] if array.ndim == 2 else array
        if array.ndim != 3 or not 1 <= array.shape[2] <= 4:
            raise InputError(f"a picture has the shape {np.shape(picture)}; it should be (rows, columns[, 1 to 4])")
        if array.dtype in (np.uint8, np.uint16):
            png = _files.png(array, level=1)
            self._file = _files.OwnedFile(self, "picture", ".png", lambda path: _write(path, png))
        else:
            tiff = _files.tiff(array.astype(np.float32))
            self._file = _files.OwnedFile(self, "picture", ".tif", lambda path: _write(path, tiff))

    @classmethod
    def volume(
        cls, volume: str | os.PathLike[str] | ArrayLike, *, origin: Sequence[float] | None = None,
        spacing: float | Sequence[float] | None = None, field: str | None = None, unit: str | None = None,
        pitch: float | None = None, outside: float | None = None, wrap: str = "clamp", filter: str = "trilinear",
    ) -> Texture:
        """A volume: a file, or an array [z][y][x] or [z][y][x][channel], whose first value is at the lowest corner.

        `origin` is that corner in part space and `spacing` the size of a texel, in mm. Of files that hold fields,
        `field` is the name of the one that is read, `unit` that of their lengths (mm, cm, m, um, in), `pitch` how
        fine their cells are sampled, in mm, and `outside` the value where they have none.
        """
        if isinstance(volume, (str, os.PathLike)):
            self = cls(volume, wrap=wrap, filter=filter)
        else:
            self = cls.__new__(cls)
            self._keys = {"wrap": wrap, "filter": filter}
            array = np.array(volume)
            if array.ndim not in (3, 4):
                raise InputError(f"a volume has the shape {array.shape}; it should be (z, y, x[, channels])")
            if array.dtype not in (np.uint8, np.uint16):
                array = array.astype(np.float32)
            self._file = _files.OwnedFile(self, "volume", ".npy", lambda path: np.save(path, array))
        if origin is not None:
            self._keys["origin_mm"] = [float(x) for x in origin]
        if spacing is not None:
            self._keys["spacing_mm"] = [float(x) for x in np.broadcast_to(np.asarray(spacing, float), 3)]
        if pitch is not None:
            self._keys["pitch_mm"] = float(pitch)
        if outside is not None:
            self._keys["outside"] = float(outside)
        self._keys.update({key: value for key, value in (("field", field), ("unit", unit)) if value is not None})
        return self

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        path = self.file if self._file is None else self._file.path()
        allow.add(path.parent)
        return {"file": str(path), **self._keys}


def _write(path: Path, data: bytes) -> None:
    path.write_bytes(data)
